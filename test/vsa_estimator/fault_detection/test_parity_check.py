# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parity residuals: their noise, their baseline, and the end of a fault."""

import numpy as np
import pytest
from vsa_estimator.fault_detection.parity_check import ParityCheck
from vsa_estimator.fault_detection.residual import DECISION_WINDOW, Coefficients, mean_residual, residuals
from vsa_estimator.fault_detection.travel import EVERYWHERE
from vsa_estimator.force_law.damper import peak_speed
from vsa_estimator.force_law.elastic import elastic_force, stiffness
from vsa_estimator.tuning.fault_detection import (
    MAX_BASELINE,
    MIN_BASELINE,
    MOVING_SPEED,
    STICTION_RATIO,
    VELOCITY_STD,
)
from vsa_estimator.tuning.force_law import UNBOUNDED_SPEED

RATE = 100.0
K2 = 267.2
MEAN = np.array([np.log(2600.0), K2, 4000.0, -1.089e8, 0.3755, 16.39, 0.3])  # s k2 d1 d2 M F0 d0
REFERENCE = 0.0095
NOISE = 1e-5  # of the encoder [m]
PEAK_SPEED = peak_speed(MEAN[2], MEAN[3])  # [m/s]


def mean_of_noise(rng, share, half=5, rows=12):
    """First row and mean residual of velocity noise over the last `share` of a window of `rows`."""
    position = 1e-5 * rng.standard_normal(rows + 2 * half)
    noise = 4000.0 * (position[2 * half :] - position[: -2 * half]) / (2 * half / RATE)
    time, first = np.arange(rows) / RATE, round((1.0 - share) * rows)
    window = (rows - 0.5) / RATE
    moving, span = np.ones(rows - first, bool), (window, time[-1])
    return mean_residual(time[first:], noise[first:], moving, time, span, 2 * half)[:2]


def test_the_mean_of_a_part_of_a_window_has_no_more_noise_than_that_of_the_whole():
    rng = np.random.default_rng(1)
    stds = {}
    for share in (1.0, 0.75, 0.5):
        means = [mean_of_noise(rng, share) for _ in range(2000)]
        assert all(first >= 0 for first, _ in means)
        stds[share] = np.std([mean for _, mean in means])
    assert stds[1.0] == pytest.approx(4000.0 * NOISE * np.sqrt(20.0) / (12 * 0.1), rel=0.1)
    assert stds[0.75] == pytest.approx(stds[1.0], rel=0.1)
    assert stds[0.5] == pytest.approx(stds[1.0], rel=0.1)


def motion(frequency, seconds=3.0, amplitude=3e-4):
    t = np.arange(round(seconds * RATE)) / RATE
    w = 2.0 * np.pi * frequency
    x = REFERENCE + amplitude * np.sin(w * t)
    return t, x, amplitude * w * np.cos(w * t), -amplitude * w * w * np.sin(w * t)


def model_force(x, v, a):
    s, k2, d1, d2, mass, offset, coulomb = MEAN
    spring = np.array([elastic_force(stiffness(s, k2, one - REFERENCE), k2) for one in x])
    return spring + d1 * v + d2 * v**3 + mass * a + offset + coulomb * np.tanh(v / 0.07e-3)


def test_a_short_baseline_has_a_small_error_by_jerk():
    t, x, v, a = motion(1.0)
    rows = np.array([t, x, model_force(x, v, a), np.zeros(t.size)])
    errors = {
        baseline: np.sqrt(np.mean(residuals(rows, MEAN, REFERENCE, baseline, (*EVERYWHERE, PEAK_SPEED))[1] ** 2))
        for baseline in (0.1, 0.04)
    }
    assert errors[0.04] < 0.3 * errors[0.1]


def check(force, x, t, noise=NOISE):
    parity = ParityCheck(RATE, PEAK_SPEED)
    parity.keep(Coefficients(MEAN.copy(), np.diag((1e-4 * MEAN) ** 2), REFERENCE))
    for sample in zip(t.tolist(), x.tolist(), force.tolist(), strict=True):
        parity.add(sample, noise**2, False)
    return parity


@pytest.mark.parametrize(
    ("noise", "baseline"), [(1e-5, MAX_BASELINE), (1e-7, MIN_BASELINE), (5e-6, np.sqrt(2.0) * 5e-6 / VELOCITY_STD)]
)
def test_the_baseline_follows_the_noise_of_the_encoder(noise, baseline):
    t, x, v, a = motion(0.5)
    assert check(model_force(x, v, a), x, t, noise)._baseline == pytest.approx(baseline, rel=0.02)


@pytest.mark.parametrize(("begin", "end"), [(5e-3, 0.0), (0.0, 5e-3)])
def test_the_threshold_of_each_window_has_the_model_error_of_its_own_steps(begin, end):
    t = np.arange(300) / RATE
    x = REFERENCE + begin + (end - begin) * np.clip((t - 2.0) / 0.3, 0.0, 1.0)  # a tight and a soft rest
    parity = check(model_force(x, np.gradient(x, t), np.zeros(t.size)), x, t)
    decision, longest = parity._windows[1, 1:]
    assert (longest if begin > end else decision) > 1.5 * (decision if begin > end else longest)


def at_rest(offset, position=REFERENCE, seconds=1.0):
    t = np.arange(round(seconds * RATE)) / RATE
    x = np.full(t.size, position)
    return t, x, model_force(x, np.zeros(t.size), np.zeros(t.size)) + offset


@pytest.mark.parametrize(("begin", "slope", "exceeded"), [(2.8, 0.0, [0]), (0.0, 0.4, [1, 2])])
def test_a_fast_fault_exceeds_the_shortest_window_alone_and_a_slow_one_does_not(begin, slope, exceeded):
    """A step of 3 N for 0.2 s, and a drift for 3 s."""
    t, x, v, a = motion(0.5)
    offset = np.where(t < begin, 0.0, slope * (t - begin) if slope else 3.0)
    assert check(model_force(x, v, a) + offset, x, t).exceeded == exceeded


def test_the_end_of_a_fault_shows_at_the_same_position():
    t, x, force = at_rest(2.0)
    parity = check(force, x, t)
    parity.begin_fault()
    parity.measure_fault()
    assert not parity.is_consistent
    for time, deflection, consistent in zip(*at_rest(0.0, seconds=2.0), strict=True):
        parity.add((1.0 + time, deflection, consistent), NOISE**2, False)
    assert parity.is_consistent
    assert parity.fault_would_show()


def test_stiction_or_a_soft_spring_hides_the_end_of_a_fault():
    shift = 1e-3  # of the encoder: 2.3 N at the reference, 0.6 N at half of that position
    t, x, force = at_rest(2600.0 / K2 * (1.0 - np.exp(-K2 * shift)))
    parity = check(force, x, t)
    parity.begin_fault()
    parity.measure_fault()
    assert not parity.is_consistent
    for time, deflection, consistent in zip(*at_rest(0.0, 0.5 * REFERENCE, 2.0), strict=True):
        parity.add((4.0 + time, deflection, consistent), NOISE**2, False)
    assert parity.is_consistent
    assert not parity.fault_would_show()
    assert parity.fault_would_show(of_encoder=False)


def test_rows_about_rejected_deflections_are_not_usable():
    t, x, v, a = motion(0.5)
    after_rejection = np.zeros(t.size)
    after_rejection[150] = 1.0
    rows = np.array([t, x, model_force(x, v, a), after_rejection])
    usable, *_, finite = residuals(rows, MEAN, REFERENCE, 0.04, (*EVERYWHERE, PEAK_SPEED))
    excluded = np.setdiff1d(finite, usable)
    assert excluded.min() == pytest.approx(1.5 - 0.02 - 0.04)
    assert excluded.max() == pytest.approx(1.5 + 0.02 + 0.04)
    assert len(excluded) == 13


def usable_forces(change):
    """Whether each force of a motion is usable, after `change` of the array of forces."""
    t, x, v, a = motion(0.5)
    force = model_force(x, v, a)
    change(force)
    usable, *_ = residuals(np.array([t, x, force, np.zeros(t.size)]), MEAN, REFERENCE, 0.04, (*EVERYWHERE, PEAK_SPEED))
    return np.isin(t[2:-2], usable)


def test_a_single_outlier_of_the_force_is_no_evidence_and_two_are():
    def set_force(at):
        def change(force):
            force[at] = 0.0

        return change

    assert np.flatnonzero(~usable_forces(set_force([150]))).tolist() == [148]
    assert usable_forces(set_force([150, 151])).all()


def test_forces_of_a_vibration_and_those_about_it_are_no_evidence():
    """Beyond v* the rod vibrates faster than the damper's peak, which the encoder does not show."""

    def change(force):
        force[150:160] += 5.0 * (-1.0) ** np.arange(10)

    usable = usable_forces(change)
    assert np.flatnonzero(~usable).tolist() == list(range(144, 162))


def test_the_first_force_of_a_stuck_sensor_is_no_evidence():
    def change(force):
        force[150], force[151:] = 0.0, np.nan  # repeated forces are excluded from updates

    usable = usable_forces(change)
    assert usable[:148].all()
    assert not usable[148:].any()


def test_forces_at_half_the_rate_of_the_encoder_are_usable():
    def change(force):
        force[1::2] = np.nan

    usable = usable_forces(change)
    assert usable[::2].all()


@pytest.mark.parametrize("share", [0.8, 1.0, 1.2])
def test_at_the_limit_of_rest_the_noise_of_the_velocity_is_no_fault(share):
    rng, excess = np.random.default_rng(2), []
    for _ in range(100):
        t = np.arange(100) / RATE
        x = REFERENCE + share * MOVING_SPEED * t
        force = model_force(x, np.full(t.size, share * MOVING_SPEED), np.zeros(t.size))
        parity = check(force, x + NOISE * rng.standard_normal(t.size), t)
        excess.append(parity._normalized(DECISION_WINDOW))
    assert np.mean(excess) < 0.05
    assert max(excess) < 0.5


def test_a_mean_residual_ends_with_the_forces():
    t, x, force = at_rest(5.0)
    parity = check(force, x, t)
    assert parity.exceeded
    for time in t[:50]:
        parity.add((t[-1] + 0.01 + time, x[0], np.nan), NOISE**2, False)
    assert not parity.exceeded


def test_the_checkpoint_extrapolates_where_the_sensors_were_not_consistent():
    t, x, force = at_rest(0.0)
    parity = check(force, x, t)
    parity.accept()
    assert not parity.extrapolates
    beyond, wrong = REFERENCE + 3e-3, 2.0
    for time, deflection, other in zip(*at_rest(wrong, beyond), strict=True):
        parity.add((2.0 + time, deflection, other), NOISE**2, False)
    parity.keep(parity.checkpoint)
    assert parity.exceeded
    assert parity.extrapolates
    parity.extend_travel()
    assert not parity.extrapolates


@pytest.mark.parametrize(("known_speed", "evidence"), [(PEAK_SPEED, False), (UNBOUNDED_SPEED, True)])
def test_a_damper_without_a_peak_counts_as_known_up_to_the_initial_peak_speed(known_speed, evidence):
    """The force of a linear damper, and coefficients whose cubic term grows with the speed instead."""
    t, speed = np.arange(150) / RATE, 1.2 * PEAK_SPEED
    x, v, mean = REFERENCE + speed * (t - 0.75), np.full(t.size, speed), MEAN.copy()
    mean[3] = -MEAN[3]
    force = model_force(x, v, np.zeros(t.size)) - MEAN[3] * v**3
    parity = ParityCheck(RATE, known_speed)
    for index, sample in enumerate(zip(t.tolist(), x.tolist(), force.tolist(), strict=True)):
        parity.add(sample, NOISE**2, False)
        if index == 0:
            parity.keep(Coefficients(mean, np.zeros((7, 7)), REFERENCE))
    assert bool(parity.exceeded) is evidence


@pytest.mark.parametrize(
    ("relative_std", "share", "usable"), [(0.05, 0.7, True), (0.05, 0.98, True), (0.05, 1.02, False), (0.2, 0.7, False)]
)
def test_a_damper_whose_peak_is_known_is_known_up_to_it(relative_std, share, usable):
    """Motion at a share of v*, with an initial v* of half of that of the coefficients."""
    t, speed = np.arange(100) / RATE, share * PEAK_SPEED
    x, v = REFERENCE + speed * (t - 0.5), np.full(t.size, speed)
    rows = np.array([t, x, model_force(x, v, np.zeros(t.size)), np.zeros(t.size)])
    covariance = np.zeros((7, 7))
    covariance[3, 3] = (relative_std * MEAN[3]) ** 2
    law = Coefficients(MEAN, covariance, REFERENCE)
    found, *_ = law.residuals(rows, 0.04, (*EVERYWHERE, 0.5 * PEAK_SPEED))
    assert (found.size > 0) is usable


def passing(parity, residual, begin, speed, seconds=2.0):
    """Error by another law that does not show, at each consistent evaluation of a motion with a `residual` [N]."""
    t = begin + np.arange(round(seconds * RATE)) / RATE
    x = REFERENCE - 0.5 * speed * seconds + speed * (t - begin)
    force = model_force(x, np.full(t.size, speed), np.zeros(t.size)) + residual(t - begin, x)
    hidden = []
    for sample in zip(t.tolist(), x.tolist(), force.tolist(), strict=True):
        if parity.add(sample, NOISE**2, False):
            parity.measure_fault()
            if parity.is_consistent:
                hidden.append(parity.hidden_change())
    return hidden


def settled():
    """A check whose residual scale is that of a healthy motion, at the begin of a fault."""
    t, x, v, a = motion(0.5)
    parity = check(model_force(x, v, a), x, t)
    for _ in range(1000):
        parity.accept()
    parity.interrupt()
    parity.begin_fault()
    return parity


def test_another_law_is_not_taken_for_consistent_where_its_force_is_the_same():
    hidden = passing(settled(), lambda _, x: 150.0 * (x - REFERENCE), begin=5.0, speed=0.75e-3, seconds=4.0)
    assert hidden
    assert hidden == pytest.approx([150.0 / 2600.0] * len(hidden), rel=0.2)  # the stiffness at REFERENCE


@pytest.mark.parametrize("speed", [0.0, 0.1e-3, 1.5e-3])
def test_the_end_of_a_sensor_fault_is_no_other_law(speed):
    hidden = passing(settled(), lambda t, _: np.where(t < 1.0, 1.0, 0.0), begin=5.0, speed=speed)
    assert hidden[-1] == 0.0


def test_a_residual_that_comes_and_goes_within_the_decision_window_is_no_other_law():
    parity = settled()
    hidden = passing(parity, lambda t, _: np.where(abs(t - 1.1) < 0.1, 1.5, 0.0), begin=5.0, speed=0.75e-3, seconds=3.0)
    assert parity.fault_size[0] > 0.0
    assert hidden
    assert not any(hidden)


def test_a_transient_step_of_the_encoder_at_rest_is_no_other_law():
    parity, hidden = settled(), []
    t, x, force = at_rest(0.0, seconds=3.0)
    faulty = t < 1.0
    for k in range(t.size):
        step = float(5.0 + t[k]), float(x[k] + 1e-3 * faulty[k]), float(force[k])
        if parity.add(step, NOISE**2, bool(k and faulty[k] != faulty[k - 1])):
            parity.measure_fault()
            if parity.is_consistent:
                hidden.append(parity.hidden_change())
    assert hidden
    assert not any(hidden)


def test_large_usual_residuals_become_small_again_with_those_of_a_healthy_motion():
    t, x, v, a = motion(0.5)
    parity = check(model_force(x, v, a), x, t)
    parity._scale._squares[:] = 1.0
    assert parity.is_insensitive
    assert not parity.is_uncertain
    for _ in range(1000):
        parity.accept()
    assert not parity.is_insensitive


def test_a_rest_leaves_the_usual_residuals_of_motion_as_they_are():
    t, x, force = at_rest(0.2)
    parity = check(force, x, t)
    before = parity._scale.std(DECISION_WINDOW)
    for _ in range(1000):
        parity.accept()
    assert parity._scale.std(DECISION_WINDOW) == pytest.approx(before)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_noise_at_rest_stays_below_the_threshold(seed):
    rng, seconds = np.random.default_rng(seed), 300.0
    t = np.arange(round(seconds * RATE)) / RATE
    x = REFERENCE + 1e-3 * np.where(t < 10.0, np.sin(2.0 * np.pi * 0.2 * t), 0.0)
    force = model_force(x, np.gradient(x, t), np.zeros(t.size)) + 0.017 * rng.standard_normal(t.size)
    x = x + NOISE * rng.standard_normal(t.size)
    parity, largest = ParityCheck(RATE, PEAK_SPEED), 0.0
    parity.keep(Coefficients(MEAN.copy(), np.diag((1e-4 * MEAN) ** 2), REFERENCE))
    for sample in zip(t.tolist(), x.tolist(), force.tolist(), strict=True):
        if parity.add(sample, NOISE**2, False) and not parity.no_evidence:
            largest = np.nanmax([largest, *(parity._normalized(window) for window in range(3))])
            parity.accept()
    assert largest < 0.9


@pytest.mark.parametrize("rate", [12.0, 30.0, 100.0])
def test_a_slow_sensor_has_residuals_in_all_windows(rate):
    t = np.arange(round(6.0 * rate)) / rate
    x = REFERENCE + 1e-3 * np.sin(2.0 * np.pi * 0.1 * t)
    parity = check(model_force(x, np.gradient(x, t), np.zeros(t.size)), x, t, noise=1e-7)
    assert np.isfinite(parity._windows[0]).all()
    assert parity.is_consistent


def test_a_fault_that_stiction_may_balance_and_hide_would_not_show_at_rest():
    size = 2.2 * STICTION_RATIO * MEAN[-1]
    shows = {}
    for share in (0.8, 2.0):
        parity = settled()
        t, x, v, a = motion(0.5)
        for sample in zip((5.0 + t).tolist(), x.tolist(), (model_force(x, v, a) + share * size).tolist(), strict=True):
            parity.add(sample, NOISE**2, False)
        parity.measure_fault()
        assert parity.fault_size[0] == pytest.approx(share * size, rel=0.1)
        for time, deflection, force in zip(*at_rest(0.0), strict=True):
            parity.add((9.0 + time, deflection, force), NOISE**2, False)
        shows[share] = parity.fault_would_show(of_encoder=False)
    assert shows == {0.8: False, 2.0: True}
