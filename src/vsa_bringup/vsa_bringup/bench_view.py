"""`./vsa bench view`: what the live page costs while a joint publishes at full rate, with a browser or without."""

import argparse
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import rclpy
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState
from vsa_bringup.demo import free_port
from vsa_bringup.isolation import claim_corner
from vsa_bringup.processes import executable
from vsa_common.stamps import set_stamp
from vsa_common.terminal import show_table
from vsa_msgs.msg import EstimatorState, JointImpedance, TransmissionImpedance

BEFORE_S = 8.0  # start of server and browser, not counted
BROWSER = "--headless --no-sandbox --disable-gpu --disable-background-networking --no-first-run --window-size=1400,1000"
STATE_EVERY = 20  # samples


def main(args: list[str] | None = None) -> int:
    """Measure both; 1 with one line on stderr where there is no browser to measure with."""
    options = _parser().parse_args(args)
    browser = shutil.which("chromium")
    if browser is None:
        print("bench view: needs chromium (Debian: apt install chromium)", file=sys.stderr)
        return 1
    os.environ.update(claim_corner().environment())
    rclpy.init()
    try:
        figures = {
            name: measure(options.rate, options.duration, path) for name, path in (("none", ""), ("chromium", browser))
        }
    finally:
        rclpy.try_shutdown()
    rows = [[name, f"{one['rate']:.0f}", f"{one['processor']:.1f}"] for name, one in figures.items()]
    show_table("The live page's server", ["browser", "samples a second", "% of a core"], rows)
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1) + "\n")
    return 0


def measure(rate: int, duration: float, browser: str) -> dict[str, float]:
    """Samples a second that were published, and processor time of the server [% of a core]."""
    port = free_port(8080)
    server = subprocess.Popen(
        [executable("vsa_bringup", "view"), "--port", str(port)], stdout=subprocess.PIPE, text=True
    )
    assert server.stdout
    server.stdout.readline()
    started: list[subprocess.Popen[Any]] = [server]
    if browser:
        command = [browser, *BROWSER.split(), "--remote-debugging-port=0", f"http://127.0.0.1:{port}/"]
        started.append(subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
    node = rclpy.create_node("bench", namespace="vsa")
    try:
        joint = _Joint(node)
        joint.publish(rate, BEFORE_S)
        before, begin = _processor(server.pid), time.monotonic()
        count = joint.publish(rate, duration)
        took = time.monotonic() - begin
        return {"rate": count / took, "processor": 100.0 * (_processor(server.pid) - before) / took}
    finally:
        node.destroy_node()
        for process in reversed(started):
            process.terminate()
            process.wait()


class _Joint:
    """What the nodes of one joint publish, as fast as they do."""

    def __init__(self, node: Any) -> None:
        side = TransmissionImpedance(status=2, stiffness=2000.0, stiffness_valid=True)
        fast = {f"transmission_{i}/impedance": side for i in (1, 2)}
        fast |= {"joint_impedance": JointImpedance(status=2), "joint_states": JointState(position=[0.1])}
        slow = {f"transmission_{i}/estimator_state": EstimatorState(status=2) for i in (1, 2)}
        self._fast = [(node.create_publisher(type(one), name, 1000), one) for name, one in fast.items()]
        self._slow = [(node.create_publisher(type(one), name, 100), one) for name, one in slow.items()]

    def publish(self, rate: int, duration: float) -> int:
        """So many samples a second for so long [s]; returns how many it were."""
        begin, count = time.monotonic(), 0
        while (now := time.monotonic() - begin) < duration:
            for _ in range(int(now * rate) - count):
                stamp_ns = time.time_ns()
                for publisher, message in self._fast + (self._slow if count % STATE_EVERY == 0 else []):
                    set_stamp(message.header.stamp, stamp_ns)
                    publisher.publish(serialize_message(message))
                count += 1
            time.sleep(0.5 / rate)
        return count


def _processor(pid: int) -> float:
    """User and system time of a process so far [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / float(os.sysconf("SC_CLK_TCK"))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="bench view", description=__doc__)
    parser.add_argument("--rate", type=int, default=1000, metavar="HZ", help="samples a second (%(default)s)")
    parser.add_argument("--duration", type=float, default=20.0, metavar="S", help="of each measurement (%(default)s s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there, too")
    return parser
