# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Evaluation of injected faults, on estimates with known errors."""

import numpy as np
import pytest
from vsa_simulator.faults.failure import TYPES, parse
from vsa_simulator.node import SimulatorConfig
from vsa_tools.evaluation.recorded_run import JOINT, Diagnostic, Frames
from vsa_tools.scenarios.fault_evaluation import (
    DIAGNOSES,
    Estimates,
    acceptance,
    evaluate_fault,
    failures,
    fault_intervals,
    recovery_time,
    rig_time,
    undetected_error,
)
from vsa_tools.scenarios.faults import FaultRecording

SECOND = 1_000_000_000
TIME = np.arange(0.0, 30.0, 0.002)
EVENTS = [(10.0, parse("force stuck -i 1 -t 2")), (20.0, parse("encoder spike -i 2"))]


def estimates(wrong=(0.0, 0.0), invalid=(0.0, 0.0)):
    off = 0.05 * ((wrong[0] <= TIME) & (wrong[1] > TIME))
    valid = ~((invalid[0] <= TIME) & (invalid[1] > TIME))
    return Estimates(TIME, off, off / 0.002, valid, valid)


def test_each_fault_is_evaluated_until_the_next():
    first, second = fault_intervals(EVENTS)
    assert (first.begin, first.end, first.until) == (10.0, 12.0, 20.0)
    assert (second.begin, second.end) == (20.0, 20.0)


def test_the_longest_undetected_error_counts_and_an_invalid_stiffness_has_none():
    first, _ = fault_intervals(EVENTS)
    assert undetected_error(estimates(wrong=(11.0, 11.3)), first) == (pytest.approx(0.3, abs=0.003), 0.05)
    assert undetected_error(estimates(wrong=(11.0, 11.3), invalid=(10.9, 11.5)), first) == (0.0, 0.0)
    assert undetected_error(estimates(wrong=(25.0, 26.0)), first) == (0.0, 0.0)


def test_recovery_time_counts_from_the_end_and_is_none_without_recovery():
    first, _ = fault_intervals(EVENTS)
    assert recovery_time(estimates(invalid=(10.5, 13.5)), first) == pytest.approx(1.5, abs=0.003)
    assert recovery_time(estimates(), first) == 0.0
    assert recovery_time(estimates(invalid=(10.5, 21.0)), first) is None
    assert (
        recovery_time(estimates(invalid=(19.99, 21.0)), first) == 0.0
    )  # the next fault with the stamp of the last sample


def test_figures_and_acceptance_of_a_fault():
    first, second = fault_intervals(EVENTS)
    diagnostics = [
        Diagnostic(5 * SECOND, "force sensor stuck"),
        Diagnostic(int(10.4e9), "transmission_1: force sensor stuck: x"),
    ]
    one = evaluate_fault(first, 10 * SECOND, diagnostics, {"transmission_1": estimates(invalid=(10.2, 12.5))})
    assert (one["diagnosed_after_s"], one["undetected_error_s"]) == (0.4, 0.0)
    met = {"diagnosed": True, "isolated": True, "valid_again": True, "no_undetected_error": True}
    assert acceptance([one]) == met
    assert failures([one]) == []
    other = evaluate_fault(second, 20 * SECOND, diagnostics, {"joint": estimates(wrong=(20.1, 20.4))})
    assert acceptance([one, other]) == met | {"diagnosed": False, "no_undetected_error": False}
    assert failures([one, other]) == [
        "encoder spike -i 2 -v 0.001 at 20 s: not diagnosed",
        "encoder spike -i 2 -v 0.001 at 20 s: wrong stiffness of joint marked valid for 0.30 s",
    ]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("transmission_1: encoder stuck: constant", "wrong isolation: transmission_1: encoder stuck: constant"),
        (
            "transmission_2: force sensor stuck: constant",
            "wrong isolation: transmission_2: force sensor stuck: constant",
        ),
    ],
)
def test_a_fault_that_is_isolated_as_another_one_fails(text, sentence):
    first, _ = fault_intervals(EVENTS)
    right = Diagnostic(int(10.4e9), "transmission_1: force sensor stuck: x")
    sources = {"transmission_1": estimates(invalid=(10.2, 12.5))}
    one = evaluate_fault(first, 10 * SECOND, [Diagnostic(int(10.2e9), text), right], sources)
    assert not acceptance([one])["isolated"]
    assert failures([one]) == [f"force stuck -i 1 -t 2 at 10 s: {sentence}"]
    late = Diagnostic(int(10.6e9), text)
    assert acceptance([evaluate_fault(first, 10 * SECOND, [right, late], sources)])["isolated"]


def test_a_fault_of_both_transmissions_is_isolated_whichever_message_arrives_first():
    (both,) = fault_intervals([(10.0, parse("force noise -t 3 -v 10"))])
    seconds = {"transmission_2": 10.2, "transmission_1": 10.1}
    diagnostics = [Diagnostic(int(at * 1e9), f"{name}: force sensor noisy") for name, at in seconds.items()]
    one = evaluate_fault(both, 10 * SECOND, diagnostics, {"joint": estimates()})
    assert (one["wrongly_isolated"], one["diagnosed_after_s"]) == ("", 0.1)


def test_a_late_diagnosis_and_a_missing_recovery_fail():
    first, _ = fault_intervals(EVENTS)
    late = Diagnostic(int(11.5e9), "transmission_1: force sensor stuck: x")
    one = evaluate_fault(first, 10 * SECOND, [late], {"transmission_1": estimates(invalid=(10.2, 30.0))})
    assert failures([one]) == [
        "force stuck -i 1 -t 2 at 10 s: diagnosed after 1.50 s",
        "force stuck -i 1 -t 2 at 10 s: not valid again",
    ]


def test_every_failure_type_has_a_diagnosis_pattern():
    assert set(TYPES) - set(DIAGNOSES) == {"ok", "slow"}


def test_the_rigs_time_is_interpolated_between_frames():
    frames, samples = np.array([0, 2, 4]) * SECOND, np.array([0, 200, 400])
    assert rig_time(np.array([SECOND, 3 * SECOND]), frames, samples, 100.0).tolist() == [1.0, 3.0]


@pytest.mark.parametrize("source", [JOINT, "transmission_1"])
def test_errors_of_stiffness_in_standard_deviations_are_those_of_its_logarithm(source):
    run = FaultRecording.__new__(FaultRecording)
    number = np.arange(5)
    run._rig, run._frames = SimulatorConfig(rate_hz=100), Frames(1_000_000_000 + 10_000_000 * number, number)
    run._truth = {f"stiffness_{i}": np.full(5, 3000.0) for i in (1, 2)}
    run._truth |= {f"damping_{i}": np.full(5, 4000.0) for i in (1, 2)}
    value = 0.4 * run._true_stiffness(source, number)
    columns = {
        "stamp_ns": run._frames.stamp_ns, "stiffness": value, "stiffness_variance": (0.5 * value) ** 2,
        "stiffness_valid": np.ones(5), "status_valid": np.ones(5, bool),
    }  # fmt: skip
    assert run._estimates(source, columns).deviations == pytest.approx(np.log(0.4) / 0.5)
