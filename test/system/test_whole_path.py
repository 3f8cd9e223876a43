# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The real nodes over a real CAN interface, from the simulated rig to the joint and the bag."""

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from vsa_common.io import bags
from vsa_common.ros.subprocesses import executable
from vsa_tools.topics import suite_topics

pytestmark = pytest.mark.live

RATE = 200
DURATION = 25.0
# Of stiffness control, which the plain demo does not have.
COMMANDS = {"/vsa/motor_commands", "/vsa/stiffness_command", "/vsa/stiffness_controller/status"}


def demo(out: Path, duration: float, *options: str) -> subprocess.Popen:
    command = [executable("vsa_tools", "demo"), "--duration", str(duration), "--rate", str(RATE), "--out", str(out)]
    command += options
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def processes_of(out: Path) -> list[str]:
    """Command lines of all living processes that were started for the run in `out`."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            words = (folder / "cmdline").read_bytes().decode(errors="replace").split("\0")
        except OSError:
            continue
        if str(out / "parameters.yaml") in words:
            found.append(" ".join(words))
    return found


def wait_for(condition, seconds: float) -> bool:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.1)
    return False


@pytest.fixture(scope="module")
def finished(tmp_path_factory) -> Iterator[Path]:
    out = tmp_path_factory.mktemp("demo")
    process = demo(out, DURATION)
    text, _ = process.communicate(timeout=240)
    assert process.returncode == 0, text
    (out / "output.txt").write_text(text)
    return out


@pytest.fixture(scope="module")
def summary(finished) -> dict:
    return json.loads((finished / "summary.json").read_text())


@pytest.fixture(scope="module", params=[signal.SIGINT, signal.SIGKILL])
def interrupted(request, tmp_path_factory) -> Iterator[tuple[int, Path, int, float]]:
    out = tmp_path_factory.mktemp("interrupted")
    process = demo(out, 60.0, "--busy", "1")
    try:
        assert wait_for(lambda: (out / "truth.csv").exists() and (out / "truth.csv").stat().st_size > 100_000, 120.0)
        assert len(processes_of(out)) == 7
        process.send_signal(request.param)
        begin = time.monotonic()
        process.wait(30.0)
        wait_for(lambda: not processes_of(out), 30.0)
        yield request.param, out, process.returncode, time.monotonic() - begin
    finally:
        process.kill()


def test_no_sample_is_lost_from_the_rig_to_the_estimators(summary):
    for side in summary["transmissions"].values():
        assert side["samples_sent"] == RATE * DURATION
        assert side["samples_lost"] == 0


def test_estimates_converge_to_the_truth_from_wrong_start_values(summary):
    for side in summary["transmissions"].values():
        assert abs(side["k2"]["start"] / side["k2"]["truth"] - 1.0) == pytest.approx(0.3)
        # after 25 s on a shared machine; five times better on an idle one
        assert side["k2"]["estimate"] == pytest.approx(side["k2"]["truth"], rel=0.03)
        assert side["stiffness_nrmse"] < 0.02
        assert side["damping_nrmse"] < 0.10
        assert side["converged_after_s"] < 15.0
    assert summary["joint"]["stiffness_nrmse"] < 0.02


def test_the_joint_has_a_message_for_nearly_every_sample(summary):
    assert summary["joint"]["messages"] >= 0.98 * RATE * DURATION
    assert summary["latency_ms"]["p50"] < 50.0


def test_the_summary_has_the_documented_form(summary):
    assert set(summary) == {"rate_hz", "duration_s", "transmissions", "joint", "latency_ms"}
    assert set(summary["transmissions"]) == {"transmission_1", "transmission_2"}
    assert set(summary["transmissions"]["transmission_1"]) == {
        "samples_sent", "samples_fused", "samples_lost", "converged_after_s", "k2", "d2", "inertia",
        "stiffness_nrmse", "damping_nrmse", "stiffness_coverage95", "damping_coverage95",
    }  # fmt: skip
    assert set(summary["transmissions"]["transmission_1"]["k2"]) == {"start", "estimate", "std", "truth"}
    assert set(summary["transmissions"]["transmission_1"]["inertia"]) == {"start", "estimate", "std", "truth", "valid"}
    assert set(summary["joint"]) == {"messages", "stiffness_nrmse", "damping_nrmse", "stiffness_coverage95"}
    assert set(summary["latency_ms"]) == {"p50", "p99", "max"}


def test_a_second_library_finds_every_topic_and_as_many_forces_as_samples(finished, summary):
    counts: Counter[str] = Counter()
    with (finished / "bag" / "bag.mcap").open("rb") as stream:
        for _, channel, _, message in make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            counts[channel.topic] += 1
            if channel.topic.endswith("/force"):
                assert message.wrench.force.x > 0.0
    assert set(suite_topics()) - COMMANDS <= set(counts)
    for side, figures in summary["transmissions"].items():
        assert counts[f"/vsa/{side}/force"] == counts[f"/vsa/{side}/encoder"] == figures["samples_sent"]


def test_table_and_report_are_written(finished):
    text = (finished / "output.txt").read_text()
    assert "transmission_1" in text
    assert "k2" in text
    assert (finished / "report.html").stat().st_size > 100_000


def test_nothing_is_left_running(finished):
    assert processes_of(finished) == []


def test_an_interrupted_demo_leaves_no_process_after_five_seconds(interrupted):
    number, out, code, seconds = interrupted
    assert code == (130 if number == signal.SIGINT else -signal.SIGKILL)
    assert processes_of(out) == []
    assert seconds < 5.0


def test_the_bag_of_an_interrupted_demo_is_readable(interrupted):
    _, out, _, _ = interrupted
    forces = [message for _, _, message in bags.read(out / "bag", ["/vsa/transmission_1/force"])]
    assert len(forces) > 100
    assert (out / "bag" / "metadata.yaml").exists()


def test_a_bus_that_does_not_exist_is_named_by_the_node(tmp_path):
    command = [executable("vsa_driver", "driver"), "--ros-args", "-p", "bus.interface:=no_such_interface"]
    environment = {**os.environ, "ROS_DOMAIN_ID": "19", "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, env=environment, check=False)
    assert done.returncode == 1
    assert "no_such_interface" in done.stderr
    assert "Traceback" not in done.stderr


def test_an_unknown_scenario_is_rejected_before_any_process_starts(tmp_path):
    command = [sys.executable, "-m", "vsa_tools.demo.command", "--scenario", "nonsense", "--out", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1
    assert "no scenario 'nonsense'" in done.stderr
    assert list(tmp_path.iterdir()) == []
