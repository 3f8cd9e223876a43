"""Driver, estimators and joint in one process: every sample goes from one to the next by a function call.

The same nodes with the same parameters, topics and services as in processes of their own; what they publish goes out
beside. A parameter file that names several joints (`/left/driver`, `/right/driver`) gets a process for each.
"""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from functools import partial
from select import select
from typing import Any

from rclpy.executors import Executor
from rclpy.subscription import Subscription
from rclpy.timer import Timer
from vsa_common.config.configuration import ConfigurationError
from vsa_common.config.joints import joints
from vsa_common.ros.idle import Coalescer
from vsa_common.ros.node import SuiteNode
from vsa_common.ros.process import run
from vsa_common.ros.subprocesses import end_with
from vsa_driver.acquisition.channel import Measurement
from vsa_driver.node import DriverNode
from vsa_estimator.node import EstimatorNode
from vsa_estimator.output.estimate import Estimate
from vsa_estimator.output.messages import impedance_fields
from vsa_joint.node import JointNode, side_of

LOOK_NS = 5_000_000  # how often one side's silence is looked for while the other speaks
FOLLOWS_NS = 10_000_000  # within which the other side's frame of the same sample comes
WAIT_S = 1e-3  # for a frame, before everything else gets its turn; its turn comes as often where frames never end
OWED = 10  # turns of everything else at most, after a turn of frames that took long
FRAMES = 4  # taken at most from one bus, before the others and everything else, which would be due all at once
SWITCH_S = 1e-4  # of Python's threads, where an interface needs one


class DirectJoint(JointNode):
    """Is handed the estimates of both sides."""

    def listen(self) -> list[Subscription]:
        return []


class DirectEstimator(EstimatorNode):
    """Is handed samples, and hands its estimates to `joint` before it publishes them."""

    def __init__(self, namespace: str, side: int, joint: JointNode) -> None:
        name, transmission = f"estimator_{side + 1}", f"transmission_{side + 1}"
        super().__init__(name, namespace, transmission=transmission)
        if self.config.transmission != transmission:
            raise ConfigurationError(f"{name}: transmission = {self.config.transmission!r}: must be {transmission}")
        self._side = side
        self._joint = joint
        self._untold: Estimate | None = None  # the one that a state is due of

    def create_inputs(self) -> list[Subscription]:
        return []

    def create_watchdogs(self) -> list[Timer]:
        return []  # the driver, who hears of silence, tells

    def process(self, stamp_ns: int, force: float, deflection: float) -> None:
        with self.lock:
            if self.active and not self.refuse(stamp_ns, "force"):
                while self.finish_pending():
                    pass
                super().process(stamp_ns, force, deflection)

    def on_published(self) -> None:
        """The other side's sample comes first."""

    def on_state_due(self, estimate: Estimate) -> None:
        self._untold = estimate

    def finish_pending(self) -> bool:
        with self.lock:
            if super().finish_pending():
                return True
            estimate, self._untold = self._untold, None
            if estimate is not None and self.active:
                self.publish_state(estimate)
            return estimate is not None

    def on_estimate(self, estimate: Estimate) -> None:
        self._joint.take(self._side, side_of(estimate.stamp_ns, impedance_fields(estimate)))
        super().on_estimate(estimate)


class DirectDriver(DriverNode):
    """Hands each sample to the estimator of its transmission before it publishes it, and tells of silence.

    All from the thread that reads the bus: what has come is taken before anything is called silent.
    """

    estimators: Mapping[str, EstimatorNode]

    def start(self) -> None:
        self._looked_ns = 0
        self.on_quiet = self._on_quiet
        super().start()

    def on_sample(self, sample: Measurement) -> None:
        self.estimators[sample.transmission].process(sample.stamp_ns, sample.force, sample.deflection)
        super().on_sample(sample)
        if not 0 <= sample.stamp_ns - self._looked_ns < LOOK_NS:
            self._looked_ns = sample.stamp_ns
            for estimator in self.estimators.values():  # by the stamps: others may still be waiting to be read
                estimator.predict_silence(sample.stamp_ns - FOLLOWS_NS - estimator.stamp_ns)

    def _on_quiet(self, until_ns: int) -> None:
        """Nothing has come: time for one thing that was left to do, and no more, as the next sample may come."""
        if not any(estimator.finish_pending() for estimator in self.estimators.values()):
            for estimator in self.estimators.values():
                estimator.predict_silence(until_ns - estimator.arrival_ns)


def nodes(namespace: str, polled: bool = False) -> list[SuiteNode[Any]]:
    """The nodes of one joint, in the order in which they start; with `polled` for `Turns` to read the bus."""
    driver, joint = DirectDriver(namespace=namespace), DirectJoint(namespace=namespace)
    sides = [int(name[-1]) - 1 for name in driver.config.transmissions]
    estimators = [DirectEstimator(namespace, side, joint) for side in sides]
    driver.estimators = {estimator.config.transmission: estimator for estimator in estimators}
    driver.polled = polled
    return [joint, *estimators, driver]


class Turns:
    """Reads the buses, and lets timers and services have their turn in between: no thread waits for another.

    While it is busy it rests for `rest_s` [s] whenever nothing is left to read.
    """

    def __init__(self, rest_s: float = 0.0) -> None:
        self._spun = 0.0
        self._rest = Coalescer(rest_s)

    def __call__(self, executor: Executor, nodes: Sequence[SuiteNode[Any]], wait_s: float) -> None:
        """One turn: what has come of frames, a few at most, then everything else, one thing for each WAIT_S."""
        drivers = (node for node in nodes if isinstance(node, DirectDriver) and node.active)
        links = [driver.link for driver in drivers if driver.link.polled]
        waited_for = [link.fileno() for link in links if link.fileno() >= 0]
        rest = self._rest.due()
        ready = select(waited_for, [], [], 0.0 if rest > 0.0 else min(wait_s, WAIT_S))[0]
        for link in links:
            for _ in range(FRAMES):
                if not link.step(0.0):
                    break
        now = time.monotonic()
        owed = min(int((now - self._spun) / WAIT_S), OWED)  # one does one thing: a busy turn must not let them pile up
        if not ready or owed:
            self._spun = now
            for _ in range(max(owed, 1)):
                executor.spin_once(timeout_sec=0.0)
        if rest > 0.0 and not ready:
            time.sleep(rest)


def each(spaces: Sequence[str]) -> int:
    """A process for each joint: Python runs one thread at a time, and joints share nothing. The worst exit code."""
    processes: list[subprocess.Popen[bytes]] = []

    def pass_on(number: int, _: object) -> None:
        for process in processes:
            process.send_signal(number)

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, pass_on)
    command, us = [sys.executable, "-m", "vsa_bringup.composed", *sys.argv[1:]], os.getpid()
    for space in spaces:
        own = [*command, "-r", f"__ns:=/{space}"]
        processes.append(subprocess.Popen(own, preexec_fn=partial(end_with, us)))
    return max(abs(process.wait()) for process in processes)


def main() -> int:
    """Entry point."""
    sys.setswitchinterval(SWITCH_S)
    try:
        found = joints(sys.argv)
    except ConfigurationError as error:
        print(f"composed: {error}", file=sys.stderr)
        return 1
    return each(found) if len(found) > 1 else run(lambda: nodes(found[0], polled=True), turn=Turns)


if __name__ == "__main__":
    sys.exit(main())
