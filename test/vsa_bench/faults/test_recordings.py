# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Cases, stamps, motions and injected faults."""

import numpy as np
import pytest
from vsa_bench.faults.cases import (
    CHANGED,
    FAULT_CASES,
    FAULTS,
    HEALTHY_CASES,
    LASTING,
    QUICK_FAULTS,
    QUICK_HEALTHY,
    RATES_HZ,
    TRANSMISSIONS,
    FaultCase,
    chosen_faults,
    chosen_healthy,
)
from vsa_bench.faults.hypotheses import COLUMNS
from vsa_bench.faults.injection import faulty
from vsa_bench.faults.motions import HEALTHY_MOTIONS, MIN_STEP_M, motion, simulate
from vsa_bench.faults.stamps import PAUSE_S, STAMPS
from vsa_simulator.rig.recording import TransmissionVariant

SECONDS, FIRST = 34.0, 3000


def recorded(fault, duration=2.0, motion_name="mix"):
    """Healthy and faulty recording at 100 Hz, and the true stiffness of both."""
    healthy = simulate(TransmissionVariant(), motion_name, SECONDS, 100, 1)
    made = faulty(FaultCase(fault, duration, motion_name, 100), 1, SECONDS)
    return healthy.recording, made.recording, healthy.stiffness, made.stiffness


def test_every_fault_has_cases_at_every_rate_and_a_hypothesis_of_the_matrix():
    assert len(set(FAULT_CASES)) == len(FAULT_CASES)
    for name, fault in FAULTS.items():
        assert fault.hypothesis in COLUMNS
        members = [one for one in FAULT_CASES if one.fault == name]
        assert {one.rate_hz for one in members} == set(RATES_HZ)
        assert any(one.fault == name for one in QUICK_FAULTS)


def test_healthy_cases_combine_transmissions_motions_and_stamps_at_all_rates():
    combinations = {(one.transmission, one.motion, one.stamps) for one in HEALTHY_CASES}
    assert len(combinations) == len(HEALTHY_CASES) == len(TRANSMISSIONS) * len(HEALTHY_MOTIONS) * len(STAMPS)
    assert {one.rate_hz for one in HEALTHY_CASES} == set(RATES_HZ)
    assert {one.motion for one in QUICK_HEALTHY} == set(HEALTHY_MOTIONS)


def test_filters_select_faults_and_healthy_recordings():
    assert list(chosen_faults(FAULT_CASES, ["force_stuck"], ["rest"], [500])) == [
        FaultCase("force_stuck", LASTING, "rest", 500), FaultCase("force_stuck", 2.0, "rest", 500)
    ]  # fmt: skip
    assert list(chosen_healthy(HEALTHY_CASES, ["force_stuck"], [], [])) == []
    assert list(chosen_healthy(HEALTHY_CASES, ["healthy"], [], [])) == list(HEALTHY_CASES)
    busy = list(chosen_healthy(HEALTHY_CASES, ["busy"], ["steps"], []))
    assert {one.stamps for one in busy} == {"busy"}
    assert {one.transmission for one in busy} == set(TRANSMISSIONS)


@pytest.mark.parametrize("name", [name for name in FAULTS if name not in CHANGED])
def test_a_transient_fault_changes_only_its_samples(name):
    healthy, made, _, _ = recorded(name)
    differs = (healthy.force != made.force) | (healthy.deflection != made.deflection)
    changed = np.flatnonzero(differs | (healthy.stamp_ns != made.stamp_ns))
    assert len(changed)
    assert FIRST <= changed[0] <= FIRST + 1
    assert changed[-1] < FIRST + 200
    assert (np.diff(made.stamp_ns) > 0).all()


def test_sensor_faults_have_their_amplitude():
    healthy, made, _, _ = recorded("force_bias_5n")
    np.testing.assert_allclose((made.force - healthy.force)[FIRST : FIRST + 200], 5.0)
    healthy, made, _, _ = recorded("force_drift_0.5n")
    np.testing.assert_allclose((made.force - healthy.force)[FIRST : FIRST + 200], 0.005 * np.arange(200), atol=1e-9)
    healthy, made, _, _ = recorded("encoder_step_0.3mm", LASTING)
    np.testing.assert_allclose((made.deflection - healthy.deflection)[FIRST:], 3e-4)
    _, made, _, _ = recorded("encoder_stuck")
    assert len(set(made.deflection[FIRST : FIRST + 200])) == 1
    healthy, made, _, _ = recorded("force_noisy", LASTING)
    assert np.std(made.force[FIRST:] - healthy.force[FIRST:]) == pytest.approx(0.17, rel=0.15)
    _, made, _, _ = recorded("force_saturated")
    assert set(made.force[FIRST : FIRST + 200]) == {200.0}


def test_late_stamps_come_fifty_milliseconds_late_at_most_and_in_bursts():
    for name in ("stamps_burst", "stamps_late"):
        healthy, made, _, _ = recorded(name, 0.05 if name == "stamps_burst" else 2.0)
        late = 1e-9 * (made.stamp_ns - healthy.stamp_ns)
        assert late.max() == pytest.approx(0.05)
        assert np.count_nonzero(late > 1e-3) == (5 if name == "stamps_burst" else 50)


def test_a_changed_transmission_has_the_truth_of_the_other_one_from_the_change_on():
    healthy, made, before, after = recorded("stiffness_changed", LASTING)
    np.testing.assert_array_equal(after[:FIRST], before[:FIRST])
    np.testing.assert_allclose(after[FIRST:] / before[FIRST:], 1.3, rtol=0.01)
    np.testing.assert_array_equal(made.force[:FIRST], healthy.force[:FIRST])
    _, _, before, after = recorded("k2_changed", LASTING)
    assert np.abs(after[FIRST:] / before[FIRST:] - 1.0).max() > 0.1


def test_stamps_increase_and_are_as_late_as_stated():
    sent = 2_000_000 * np.arange(60_000)
    delays = {name: 1e-9 * (make(sent, np.random.default_rng(1)) - sent) for name, make in STAMPS.items()}
    assert all((np.diff(sent + 1e9 * one) > 0).all() for one in delays.values())
    assert not delays["exact"].any()
    assert np.std(delays["jittered"]) == pytest.approx(1e-4, rel=0.05)
    assert np.mean(delays["late"]) == pytest.approx(3e-4, rel=0.05)
    assert delays["late"].min() >= 0.0
    assert 0.8 * PAUSE_S[1] < delays["busy"].max() < PAUSE_S[1] + 0.01
    assert np.quantile(delays["busy"], 0.999) > np.quantile(delays["late"], 0.999)


def test_steps_are_fast_moves_with_rests_between():
    one = motion("steps", 200.0, 3)
    positions, move = one.table[:, 0], one.table[0, 1]
    moves = np.flatnonzero(np.diff(positions))
    assert np.abs(np.diff(positions)[moves]).min() >= MIN_STEP_M
    assert (positions >= 0.005).all()
    assert (positions <= 0.017).all()
    rests = 2.0 * move * np.diff(moves) - move
    assert rests.min() > 1.2
    assert rests.max() < 10.5
    assert motion("steps", 200.0, 4).table.tolist() != one.table.tolist()


@pytest.mark.parametrize("name", [*HEALTHY_MOTIONS, "rest"])
def test_a_recording_is_continuous_also_after_its_introduction(name):
    made = simulate(TransmissionVariant(), name, SECONDS, 1000, 2)
    recording = made.recording
    assert len(recording.stamp_ns) == len(recording.force) == len(made.stiffness) == 34_000
    assert (np.diff(recording.stamp_ns) == 1_000_000).all()
    assert np.abs(np.diff(recording.deflection)).max() < 2e-4
    if name == "rest":
        assert np.ptp(recording.deflection[25_500:]) < 2e-4
