# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The estimator with faulty, late, missing and uneven samples."""

import copy
import dataclasses
import functools
import math

import numpy as np
import pytest
from transmission_data import MULTISINE, SLOW, TRANSMISSION_1, column, record, run, wrong_start
from vsa_common.types import ResetReason, Status
from vsa_estimator.estimator import Estimator
from vsa_estimator.output.estimate import Estimate
from vsa_estimator.settings import EstimatorConfig

SECOND = 1_000_000_000


def rows(recording):
    return zip(recording.stamp_ns.tolist(), recording.force.tolist(), recording.deflection.tolist(), strict=True)


@functools.cache
def _converged(seconds, motion):
    recording = record(TRANSMISSION_1, motion, seconds + 10.0)
    samples = list(rows(recording))
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    for sample in samples[: int(100 * seconds)]:
        estimate = estimator.add(*sample)
    assert estimate.status is Status.VALID
    return estimator, estimate, samples[int(100 * seconds) :], recording.stiffness[int(100 * seconds) :]


def converged(seconds=16.0, motion=SLOW):
    """An estimator that tracks transmission 1, and the samples that follow."""
    return copy.deepcopy(_converged(seconds, motion))


def all_finite(estimate: Estimate) -> bool:
    return all(math.isfinite(value) for value in estimate)


@pytest.mark.parametrize("bad", [(math.nan, 0.01), (20.0, math.inf), (-math.inf, math.nan)])
def test_a_non_finite_number_is_dropped_counted_and_leaves_the_state_unchanged(bad):
    estimator, _, rest, _ = converged()
    before = estimator.state()
    assert estimator.add(rest[0][0], *bad) is None
    after = estimator.state()
    assert after.samples_dropped == before.samples_dropped + 1
    assert after == before._replace(samples_dropped=after.samples_dropped)


def test_zero_repeated_and_late_stamps_are_dropped_and_counted():
    estimator, estimate, rest, _ = converged()
    before = estimator.state().samples_dropped
    for stamp_ns in (0, -5, estimate.stamp_ns, estimate.stamp_ns - 20_000_000):
        assert estimator.add(stamp_ns, *rest[0][1:]) is None
    assert estimator.state().samples_dropped == before + 4
    assert estimator.add(*rest[0]).stamp_ns == rest[0][0]


def test_time_that_jumps_back_resets_everything_and_output_goes_on():
    estimator, estimate, _, _ = converged()
    first = next(rows(record(TRANSMISSION_1, SLOW, 1.0)))
    again = estimator.add(*first)
    assert again.stamp_ns == first[0] < estimate.stamp_ns
    assert (again.reset_count, again.reset_reason, again.status) == (1, ResetReason.TIME_JUMP, Status.CONVERGING)


def test_a_recording_replayed_after_a_reset_gives_the_same_numbers_to_the_bit():
    recording = record(TRANSMISSION_1, MULTISINE, 14.0)
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    once = run(estimator, recording)
    estimator.reset()
    twice = run(estimator, recording)
    assert [estimate._replace(reset_count=0, reset_reason=ResetReason.NONE) for estimate in twice] == once


@pytest.mark.parametrize("sensor", ["force", "deflection"])
@pytest.mark.parametrize("rate", [100, 200, 250, 1000])
def test_a_hundred_sigma_spike_moves_no_estimate_by_more_than_one_standard_deviation(sensor, rate):
    recording = record(TRANSMISSION_1, MULTISINE, 20.0, rate=rate)
    samples = list(rows(recording))
    clean, spiked = Estimator(wrong_start(TRANSMISSION_1)), Estimator(wrong_start(TRANSMISSION_1))
    at = 18 * rate
    for index, (stamp_ns, force, deflection) in enumerate(samples):
        expected = clean.add(stamp_ns, force, deflection)
        if index == at:
            force, deflection = (force + 1.7, deflection) if sensor == "force" else (force, deflection + 1e-3)
        estimate = spiked.add(stamp_ns, force, deflection)
        for name in ("deflection", "velocity", "stiffness", "damping", "inertia", "k2", "d2"):
            std = math.sqrt(getattr(expected, f"{name}_variance"))
            assert abs(getattr(estimate, name) - getattr(expected, name)) <= std, (name, index - at)
    state = spiked.state()
    assert state.reset_count == 0
    assert (state.force_rejected if sensor == "force" else state.deflection_rejected) >= 1


def test_a_rezeroed_encoder_is_rejected_then_the_position_is_reset_with_stiffness_k2_and_d2_kept():
    estimator, before, rest, stiffness = converged()
    for index, (stamp_ns, force, deflection) in enumerate(rest):
        estimate = estimator.add(stamp_ns, force, deflection - 3e-3)
        if index == 15:
            assert estimate.reset_count == 0
    state = estimator.state()
    assert (estimate.reset_count, estimate.reset_reason) == (1, ResetReason.DEFLECTION)
    assert state.deflection_rejected > 15
    assert estimate.k2 == pytest.approx(before.k2, abs=3.0 * math.sqrt(before.k2_variance))
    assert estimate.d2 == pytest.approx(before.d2, abs=3.0 * math.sqrt(before.d2_variance))
    assert estimate.stiffness == pytest.approx(stiffness[-1], rel=0.01)
    assert estimate.deflection == pytest.approx(rest[-1][2] - 3e-3, abs=5e-5)


def test_an_encoder_step_before_hand_over_is_reported():
    recording = record(TRANSMISSION_1, SLOW, 1.0)
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    for index, (stamp_ns, force, deflection) in enumerate(rows(recording)):
        estimator.add(stamp_ns, force, deflection - (3e-3 if index > 50 else 0.0))
    assert "encoder step of -3.0" in estimator.state().reason


def test_a_slow_stream_continues_after_an_encoder_step():
    recording = record(TRANSMISSION_1, SLOW, 60.0, rate=5)
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    for index, (stamp_ns, force, deflection) in enumerate(rows(recording)):
        estimate = estimator.add(stamp_ns, force, deflection - (3e-3 if index > 200 else 0.0))
        assert all_finite(estimate)


def test_a_stuck_encoder_is_reported_and_recovers():
    estimator, _, rest, _ = converged()
    stuck = [estimator.add(stamp_ns, force, rest[0][2]) for stamp_ns, force, _ in rest[:300]]
    assert stuck[-1].status is Status.DEGRADED
    assert "encoder" in estimator.state().reason
    for sample in rest[300:]:
        estimate = estimator.add(*sample)
    assert estimate.status is Status.VALID
    assert estimate.k2 == pytest.approx(TRANSMISSION_1.k2, rel=0.01)


def test_a_stuck_force_sensor_is_reported_and_recovers():
    estimator, before, rest, _ = converged()
    stuck = [estimator.add(stamp_ns, rest[0][1], deflection) for stamp_ns, _, deflection in rest[:300]]
    assert stuck[-1].status is Status.DEGRADED
    assert "force sensor" in estimator.state().reason
    assert stuck[-1].k2 == pytest.approx(before.k2, rel=1e-3)
    for sample in rest[300:]:
        estimate = estimator.add(*sample)
    assert estimate.status is Status.VALID


def test_saturation_is_flagged_and_updates_no_coefficient():
    estimator, before, rest, _ = converged()
    for stamp_ns, _, deflection in rest[:100]:
        estimate = estimator.add(stamp_ns, 200.0, deflection)
    assert estimate.status is Status.DEGRADED
    assert "saturated" in estimator.state().reason
    for name in ("k2", "d2"):  # correlated with x, which the encoder still updates
        std = math.sqrt(getattr(before, f"{name}_variance"))
        assert getattr(estimate, name) == pytest.approx(getattr(before, name), abs=0.3 * std)


def test_held_force_samples_are_counted_and_not_used():
    recording = record(TRANSMISSION_1, MULTISINE, 20.0, rate=500)
    held = recording.force[(np.arange(recording.force.size) * 3 // 10) * 10 // 3]
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    for stamp_ns, force, deflection in zip(recording.stamp_ns, held, recording.deflection, strict=True):
        estimate = estimator.add(int(stamp_ns), float(force), float(deflection))
    assert estimator.state().force_repeated == pytest.approx(0.7 * held.size, rel=0.01)
    assert estimate.k2 == pytest.approx(TRANSMISSION_1.k2, rel=0.01)


def test_the_estimate_of_a_sample_does_not_depend_on_when_its_filter_step_is_made():
    data = record(TRANSMISSION_1, MULTISINE, 12.0, rate=500)
    prompt, late = Estimator(EstimatorConfig()), Estimator(EstimatorConfig())
    waits = 0
    for sample in zip(data.stamp_ns.tolist(), data.force.tolist(), data.deflection.tolist(), strict=True):
        before = prompt._supervisor.step_ns
        estimate = prompt.add(*sample)
        estimated_before_the_step = prompt._supervisor.step_ns == before
        while prompt.finish_pending():
            pass
        waits += estimated_before_the_step and prompt._supervisor.step_ns > before
        assert estimate == late.add(*sample)
    assert waits > 1000
    assert prompt.state() == late.state()
    assert not late.finish_pending()


def test_silence_widens_the_interval_then_is_stale_and_then_invalid():
    estimator, estimate, rest, _ = converged()
    soon, later, late = (estimator.predict_to(estimate.stamp_ns + int(1e6 * ms)) for ms in (20, 50, 100))
    assert soon.status is Status.VALID
    assert (later.status, later.stiffness_valid) == (Status.STALE, True)
    assert (late.status, late.stiffness_valid, late.damping_valid) == (Status.STALE, False, False)
    assert estimate.stiffness_variance < soon.stiffness_variance < later.stiffness_variance < late.stiffness_variance
    assert estimator.add(*rest[0]).status is Status.VALID


def test_after_a_long_gap_the_coefficients_are_kept():
    estimator, _, rest, stiffness = converged()
    for stamp_ns, force, deflection in rest[:200]:
        estimate = estimator.add(stamp_ns + 5 * SECOND, force, deflection)
    assert (estimate.reset_count, estimate.reset_reason) == (1, ResetReason.GAP)
    assert estimate.status is Status.VALID
    assert estimate.stiffness == pytest.approx(stiffness[199], rel=0.01)


def test_another_transmission_is_detected_and_identified():
    estimator, _, _, _ = converged()
    other = record(TRANSMISSION_1.__class__(k1=2.0, k2=220.0, force_offset=12.0), SLOW, 25.0)
    for stamp_ns, force, deflection in rows(other):
        estimate = estimator.add(stamp_ns + 20 * SECOND, force, deflection)
    assert estimate.reset_count >= 1
    assert estimate.status is Status.VALID
    assert estimate.k2 == pytest.approx(220.0, rel=0.01)


def test_before_the_hand_over_the_initial_peak_speed_decides_whether_the_rod_vibrates():
    recording = record(TRANSMISSION_1, (0.0105, ((1.5e-3, 1.3),)), 0.8)
    estimator, beyond = Estimator(wrong_start(TRANSMISSION_1, elastic_law="exponential")), []
    for sample in rows(recording):
        estimator.add(*sample)
        beyond.append(bool(estimator._pipeline.state["beyond_peak_speed"][0]))
    assert not estimator._supervisor.modes.initialized
    fast = np.abs(np.gradient(recording.deflection, 0.01)) > 6e-3
    assert np.mean(np.array(beyond)[fast][5:]) > 0.8


def test_uneven_stamps_and_lost_samples_keep_the_accuracy():
    rng = np.random.default_rng(3)
    t = np.cumsum(rng.uniform(0.005, 0.015, 3000))
    t = t[rng.random(t.size) > 0.05]
    recording = record(TRANSMISSION_1, MULTISINE, stamps=t)
    estimates = run(Estimator(wrong_start(TRANSMISSION_1)), recording)
    error = np.log(column(estimates, "stiffness") / recording.stiffness)[2000:]
    assert np.sqrt(np.mean(error**2)) < 0.003


def test_every_output_is_finite_for_any_input():
    rng = np.random.default_rng(4)
    estimator = Estimator(EstimatorConfig())
    stamp_ns = SECOND
    for _ in range(4000):
        stamp_ns += int(rng.choice([0, 1, 10_000_000, 10_000_000, 10_000_000, 700_000_000, -30_000_000]))
        force = float(rng.choice([0.0, 20.0, 1e300, -1e300, 5e-324, rng.standard_normal() * 100, math.nan]))
        deflection = float(rng.choice([0.0, 0.01, 1e300, -1e9, rng.standard_normal() * 0.01, math.inf]))
        estimate = estimator.add(stamp_ns, force, deflection)
        assert estimate is None or all_finite(estimate)
        assert all_finite([value for value in estimator.state() if isinstance(value, float)])


def test_inertia_of_a_light_mass_at_slow_speed_is_never_valid_and_the_needed_motion_is_named():
    recording = record(TRANSMISSION_1, SLOW, 20.0)
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    assert not any(estimate.inertia_valid for estimate in run(estimator, recording))
    assert any("inertia" in line and "0.7 Hz" in line for line in estimator.state().observability)


def test_a_heavy_mass_on_one_slow_tone_has_a_consistent_interval_and_an_invalid_inertia():
    heavy = dataclasses.replace(TRANSMISSION_1, mass=375.5)
    recording = record(heavy, SLOW, 40.0)
    estimator = Estimator(wrong_start(heavy))
    estimates = run(estimator, recording)
    stiffness = column(estimates, "stiffness")
    std = np.sqrt(column(estimates, "stiffness_variance")) / stiffness
    inside = np.abs(np.log(stiffness / recording.stiffness)) < 1.96 * std
    assert inside[2000:].mean() > 0.85
    assert not any(estimate.inertia_valid for estimate in estimates)
    assert estimates[-1].k2 == pytest.approx(heavy.k2, abs=3.0 * math.sqrt(estimates[-1].k2_variance))


def test_on_a_short_stroke_k2_and_damping_are_invalid_and_the_stiffness_interval_holds():
    recording = record(TRANSMISSION_1, (0.009, ((1.05e-3, 0.5),)), 40.0)
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    estimates = run(estimator, recording)
    stiffness = column(estimates, "stiffness")
    std = np.sqrt(column(estimates, "stiffness_variance")) / stiffness
    assert (np.abs(np.log(stiffness / recording.stiffness)) < 2.0 * std)[100:].mean() > 0.9
    assert not estimator.state().k2_valid
    assert not any(estimate.damping_valid for estimate in estimates)
    assert any("k2: not observable" in line for line in estimator.state().observability)


def test_noise_and_limits_can_change_without_losing_the_estimate():
    estimator, before, rest, truth = converged()
    changed = dataclasses.replace(estimator.config, force_noise_std=0.05, force_limit=rest[200][1] - 1.0)
    estimator.reconfigure(changed)
    state = estimator.state()
    assert (state.force_noise_std, state.reset_count) == (0.05, 0)
    estimates = [estimator.add(*sample) for sample in rest[:100]]
    assert estimates[0].k2 == pytest.approx(before.k2, rel=1e-3)
    assert all(one.stiffness_valid for one in estimates)
    assert column(estimates, "stiffness") == pytest.approx(truth[:100], rel=0.02)
    estimates = [estimator.add(*sample) for sample in rest[100:300]]
    assert "saturated" in estimator.state().reason or Status.DEGRADED in {one.status for one in estimates}


def test_a_changed_configuration_has_the_effect_of_a_new_one():
    recording = record(TRANSMISSION_1, SLOW, 5.0)
    config = wrong_start(TRANSMISSION_1)
    changed = dataclasses.replace(config, force_noise_std=0.03, deflection_noise_std=2e-5, deflection_limit=0.05)
    one, other = Estimator(config), Estimator(changed)
    one.reconfigure(changed)
    assert run(one, recording) == run(other, recording)
