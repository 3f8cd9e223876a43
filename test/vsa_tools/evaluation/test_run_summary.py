# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Summary of a run from its bag and truth, and its table in the paper's units."""

import json

import numpy as np
import pytest
from rclpy.serialization import serialize_message
from vsa_common.io.bags import Recording
from vsa_common.io.tables import write_columns
from vsa_common.stamps import set_stamp
from vsa_msgs.msg import CaptureCounters, EstimatorState, JointImpedance, TransmissionImpedance
from vsa_tools.demo.parameters import base_parameters, write_parameters
from vsa_tools.evaluation.run_summary import summarise
from vsa_tools.evaluation.run_table import show
from vsa_tools.topics import suite_topics

N, RATE = 200, 100
START_NS = 1_700_000_000_000_000_000
STIFFNESS, DAMPING = {1: 4000.0, 2: 3000.0}, {1: 3900.0, 2: 3800.0}


def stamps(side: int) -> list[int]:
    """Capture stamps; the second frame of a sample follows the first by 0.1 ms."""
    return [START_NS + k * 10_000_000 + side * 100_000 for k in range(N)]


def record_side(recording: Recording, side: int) -> None:
    space = f"/vsa/transmission_{side}"
    counters = CaptureCounters(counter=range(N))
    for stamp_ns in stamps(side):
        impedance = TransmissionImpedance(
            stiffness=1.01 * STIFFNESS[side],
            stiffness_variance=400.0,
            damping=DAMPING[side],
            damping_variance=100.0,
        )
        set_stamp(impedance.header.stamp, stamp_ns)
        counters.stamp.append(type(impedance.header.stamp)())
        set_stamp(counters.stamp[-1], stamp_ns)
        recording.write(f"{space}/impedance", stamp_ns, serialize_message(impedance))
    recording.write(f"{space}/capture_counters", stamps(side)[-1], serialize_message(counters))
    state = EstimatorState(
        samples_fused=N - 1, k2=260.0, k2_variance=4.0, d2=-1e8, inertia=0.4, inertia_valid=side == 1
    )
    recording.write(f"{space}/estimator_state", stamps(side)[-1], serialize_message(state))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    run = tmp_path_factory.mktemp("run")
    recording = Recording(run / "bag")
    for topic, type_name in suite_topics().items():
        recording.add(topic, type_name)
    for side in (1, 2):
        record_side(recording, side)
    for first, second in zip(stamps(1), stamps(2), strict=True):
        joint = JointImpedance(stiffness=0.8, damping=0.5, stiffness_variance=1.0)
        set_stamp(joint.header.stamp, second)
        set_stamp(joint.transmission_stamp[0], first)
        set_stamp(joint.transmission_stamp[1], second)
        recording.write("/vsa/joint_impedance", second, serialize_message(joint))
    recording.close()
    truth = {f"stiffness_{i}": np.full(N, STIFFNESS[i]) for i in (1, 2)}
    truth |= {f"damping_{i}": np.full(N, DAMPING[i]) for i in (1, 2)}
    write_columns(run / "truth.csv", truth)
    write_parameters(run / "parameters.yaml", base_parameters(), {"rig_simulator": {"rate_hz": RATE}})
    return run


@pytest.fixture(scope="module")
def summary(folder):
    arrivals = [(stamp_ns, stamp_ns + 2_000_000) for stamp_ns in stamps(2)]
    without_frame = [(0, START_NS), (stamps(2)[-1], START_NS + 10**12), (stamps(2)[-1] + 5, START_NS + 10**12)]
    return summarise(folder, arrivals + without_frame)


def test_figures_are_those_of_the_recording(summary):
    side = summary["transmissions"]["transmission_1"]
    assert (side["samples_sent"], side["samples_fused"], side["samples_lost"]) == (N, N - 1, 1)
    assert side["stiffness_nrmse"] == pytest.approx(0.01)
    assert side["damping_nrmse"] == 0.0
    assert side["k2"] == {"start": 267.2, "estimate": 260.0, "std": 2.0, "truth": 267.2}
    assert side["inertia"]["valid"] is True
    assert summary["transmissions"]["transmission_2"]["k2"]["truth"] == 165.6
    assert (summary["rate_hz"], summary["duration_s"], summary["joint"]["messages"]) == (RATE, N / RATE, N)


def test_the_joint_is_compared_with_the_true_transmissions(summary):
    true = 0.0215**2 * sum(s * 1e5 / (4e5 + s) for s in STIFFNESS.values())
    assert summary["joint"]["stiffness_nrmse"] == pytest.approx(abs(0.8 - true) / true)


def test_messages_without_a_new_frame_have_no_latency(summary):
    assert summary["latency_ms"] == {"p50": 2.0, "p99": 2.0, "max": 2.0}


def test_the_summary_is_plain_json(summary):
    assert json.loads(json.dumps(summary)) == summary


def test_the_table_is_in_the_units_of_the_paper(summary, capsys):
    show(summary)
    text = capsys.readouterr().out
    assert "0.26" in text
    assert "1/mm" in text
    assert "not observable" in text
    assert "1 / 200" in text


DEFLECTION, FORCE = {1: 0.0100, 2: 0.0090}, {1: 45.0, 2: 46.0}


@pytest.fixture(scope="module")
def other_laws(folder, tmp_path_factory):
    """Summary of the same recording with a quadratic spring and a soft knee."""
    run = tmp_path_factory.mktemp("other")
    (run / "bag").symlink_to(folder / "bag")
    truth = {f"stiffness_{i}": np.full(N, STIFFNESS[i]) for i in (1, 2)}
    truth |= {f"damping_{i}": np.full(N, DAMPING[i]) for i in (1, 2)}
    truth |= {f"deflection_{i}": np.full(N, DEFLECTION[i]) for i in (1, 2)}
    truth |= {f"force_{i}": np.full(N, FORCE[i]) for i in (1, 2)}
    write_columns(run / "truth.csv", truth)
    laws = {"rate_hz": RATE, "spring": {"kind": "quadratic"}, "damper": {"kind": "soft_knee"}}
    write_parameters(run / "parameters.yaml", base_parameters(), {"rig_simulator": laws})
    return summarise(run, [])


def test_with_other_laws_stiffness_and_damping_at_the_end_have_start_estimate_and_truth(other_laws):
    side = other_laws["transmissions"]["transmission_1"]
    start = 267.2 * (45.0 - 16.39)
    assert side["stiffness"] == pytest.approx({"start": start, "estimate": 4040.0, "std": 20.0, "truth": 4000.0})
    assert side["damping"] == pytest.approx({"start": 4000.0, "estimate": 3900.0, "std": 10.0, "truth": 3900.0})


def test_with_other_laws_the_truth_of_k2_is_the_local_slope_and_d2_has_none(other_laws):
    for i in (1, 2):
        side, u = other_laws["transmissions"][f"transmission_{i}"], DEFLECTION[i] / 0.020
        assert side["k2"]["truth"] == pytest.approx(1.84 / (0.08 + 1.84 * u) / 0.020, rel=1e-5)
        assert side["d2"]["truth"] is None


def test_with_other_laws_the_table_lists_stiffness_and_damping(other_laws, capsys):
    show(other_laws)
    text = capsys.readouterr().out
    assert "stiffness, N/mm" in text
    assert "damping, N s/mm" in text
    assert "k2" not in text
    assert "+1.00 %" in text
