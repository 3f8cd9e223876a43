# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Motion and snap density of simulated white snap."""

import numpy as np
import pytest
from scipy.stats import chi2
from vsa_estimator.general.encoder_motion import EncoderMotion, smooth
from vsa_estimator.general.records import ENCODER, MOTION, STEP, X
from vsa_estimator.tuning.general import DENSITY_WINDOW, MIN_SNAP_DENSITY, ONSET_TIME, SNAP_SCALE

DT, VARIANCE = 0.01, 1e-10


def white_snap(density, steps, seed):
    """Motion (steps, 4) driven by white snap [m^2/s^7], integrated at a tenth of DT, and its measured deflection."""
    random, h = np.random.default_rng(seed), DT / 10.0
    state, out = np.array([0.010, 0.0, 0.0, 0.0]), np.empty((steps, MOTION))
    for n in range(steps):
        for _ in range(10):
            x, v, a, j = state
            step = (x + h * v + h * h * a / 2.0 + h**3 * j / 6.0, v + h * a + h * h * j / 2.0, a + h * j, j)
            state = np.array(step)
            state[3] += np.sqrt(density * h) * random.standard_normal()
        out[n] = state
    return out, out[:, 0] + np.sqrt(VARIANCE) * random.standard_normal(steps)


def filtered(deflections):
    """Means (n, 4), covariances (n, 4, 4) and densities (n,) after each deflection."""
    motion, record = EncoderMotion(), np.zeros(1, ENCODER)
    motion.restart(deflections[0], VARIANCE)
    rows = np.zeros(len(deflections), ENCODER)
    for n, deflection in enumerate(deflections):
        if n:
            motion.add(DT, deflection, VARIANCE)
        motion.write(record)
        rows[n] = record[0]
    return rows


@pytest.mark.parametrize("density", [1e-3, 1e-1, 10.0])
def test_the_density_of_white_snap_is_found(density):
    _, measured = white_snap(density, 1200, seed=2)
    assert 0.3 < filtered(measured)["density"][-1] / (SNAP_SCALE * density) < 3.0


def test_the_motion_is_recovered_within_its_covariance():
    truth, measured = white_snap(0.1, 1500, seed=3)
    rows = filtered(measured)
    error = rows["mean"] - truth
    nees = np.array([e @ np.linalg.solve(p, e) for e, p in zip(error[500:], rows["covariance"][500:], strict=True)])
    # Errors are correlated over some 0.1 s: about 100 independent ones.
    assert chi2.ppf(1e-4, 400) / 100 < nees.mean() < chi2.ppf(1.0 - 1e-4, 400) / 100
    assert np.std(error[500:, 0]) < np.std(measured[500:] - truth[500:, 0])


def test_at_rest_the_density_is_at_its_lower_limit():
    measured = 0.010 + np.sqrt(VARIANCE) * np.random.default_rng(4).standard_normal(1200)
    rows = filtered(measured)
    assert rows["density"][-1] == MIN_SNAP_DENSITY
    assert abs(rows["mean"][-1][1]) < 1e-4


def test_in_a_steady_motion_the_density_changes_at_the_end_of_a_window_only():
    _, measured = white_snap(10.0, 1000, seed=5)
    density = filtered(measured)["density"]
    window = round(DENSITY_WINDOW / DT)
    changes = np.flatnonzero(np.diff(density)) + 1
    changes = changes[changes > 2 * window]
    assert len(changes) > 1
    assert all(min(change % window, -change % window) <= 1 for change in changes)


@pytest.mark.parametrize("seed", range(4))
def test_at_the_onset_of_a_faster_motion_the_density_rises_at_once(seed):
    onset, steps = 500, round(2.0 * ONSET_TIME / DT)
    _, slow = white_snap(1e-3, onset, seed)
    _, fast = white_snap(1e3, 100, seed)
    rows = filtered(np.concatenate([slow, fast - fast[0] + slow[-1]]))["density"]
    assert rows[onset - 1] < 1.0 * SNAP_SCALE
    assert rows[onset + steps : onset + 2 * steps].max() > 30.0 * SNAP_SCALE


def test_an_onset_is_stated_until_the_faster_motion_is_that_of_the_window():
    _, slow = white_snap(1e-3, 500, seed=0)
    _, fast = white_snap(1e3, 200, seed=0)
    motion, record, onsets = EncoderMotion(), np.zeros(1, ENCODER), []
    motion.restart(slow[0], VARIANCE)
    for deflection in np.concatenate([slow[1:], fast - fast[0] + slow[-1]]):
        motion.add(DT, deflection, VARIANCE)
        motion.write(record)
        onsets.append(motion.is_onset)
    assert not any(onsets[200:499])
    assert any(onsets[499:549])
    assert not any(onsets[600:])


def test_a_start_from_rest_is_an_onset_until_the_motion_has_settled():
    at, steps = 100, round(ONSET_TIME / DT)
    measured = 0.010 + 2e-3 * DT * np.maximum(np.arange(200) - at, 0)  # 2 mm/s
    motion, record, onsets = EncoderMotion(), np.zeros(1, ENCODER), []
    motion.restart(measured[0], VARIANCE)
    for deflection in measured[1:]:
        motion.add(DT, deflection, VARIANCE)
        motion.write(record)
        onsets.append(motion.is_onset)
    first = onsets.index(True)
    assert at <= first < at + 10
    assert all(onsets[first : first + steps])
    assert not any(onsets[first + 5 * steps :])


def test_a_restart_keeps_the_density():
    _, measured = white_snap(0.1, 1000, seed=6)
    motion, record = EncoderMotion(), np.zeros(1, ENCODER)
    motion.restart(measured[0], VARIANCE)
    for deflection in measured[1:]:
        motion.add(DT, deflection, VARIANCE)
    motion.write(record)
    density = float(record["density"][0])
    motion.restart(0.005, VARIANCE)
    motion.write(record)
    assert record["density"][0] == density
    assert record["mean"][0] == pytest.approx([0.005, 0.0, 0.0, 0.0])


def stored(deflections, density):
    """Steps of these deflections, all with one snap density [m^2/s^7]."""
    steps = np.zeros(len(deflections), STEP)
    steps["dt"], steps["deflection"], steps["deflection_variance"] = DT, deflections, VARIANCE
    steps["encoder"]["density"] = density
    return steps


def by_all_deflections(deflections, density, mean, covariance):
    """Motions (n, 4) and covariances (n, 4, 4) by all deflections: conditional moments of the joint Gaussian."""
    n, powers = len(deflections), np.arange(MOTION)
    lag = powers[None] - powers[:, None]
    step = np.where(lag >= 0, DT ** np.maximum(lag, 0) / np.array([1, 1, 2, 6])[np.maximum(lag, 0)], 0.0)
    rest, factorial = 3 - powers, np.array([6, 2, 1, 1])
    noise = density * DT ** (rest[:, None] + rest[None] + 1.0) / (rest[:, None] + rest[None] + 1.0)
    noise /= np.outer(factorial, factorial)
    joint, prior = np.zeros((n, MOTION, n, MOTION)), np.zeros((n, MOTION))
    for k in range(n):
        covariance = step @ covariance @ step.T + noise
        prior[k] = mean = step @ mean
        ahead = covariance
        for later in range(k, n):
            joint[later, :, k], joint[k, :, later] = ahead, ahead.T
            ahead = step @ ahead
    measured = joint[:, X, :, X] + VARIANCE * np.eye(n)
    gain = np.linalg.solve(measured, joint[:, X].reshape(n, -1)).T
    posterior = joint.reshape(n * MOTION, -1) - gain @ joint[:, X].reshape(n, -1)
    motion = prior + (gain @ (deflections - prior[:, X])).reshape(n, MOTION)
    return motion, np.array([posterior[k : k + MOTION, k : k + MOTION] for k in range(0, n * MOTION, MOTION)])


def test_a_smoothed_motion_is_that_by_all_deflections():
    density, mean, covariance = 0.1, np.array([0.01, 0.0, 0.0, 0.0]), np.diag([1e-8, 1e-6, 1e-4, 1e-2])
    _, measured = white_snap(density, 40, seed=4)
    steps, running = stored(measured, density), (mean[:, None].copy(), covariance.copy())
    for first, count, lag in ((0, 10, 20), (10, 5, 25)):
        smooth(steps[first : first + count + lag], count, *running)
        data = measured[: first + count + lag]
        motion, covariances = by_all_deflections(data, density, mean, covariance)
        part = slice(first, first + count)
        std = np.sqrt(np.diagonal(covariances[part], axis1=1, axis2=2))
        assert (steps["smoothed"][part] - motion[part]) / std == pytest.approx(0.0, abs=1e-5)
        scale = std[:, :, None] * std[:, None]
        assert steps["smoothed_covariance"][part] / scale == pytest.approx(covariances[part] / scale, abs=1e-5)


def test_a_gap_separates_the_smoothed_motions():
    _, measured = white_snap(0.1, 30, seed=5)
    before, both = stored(measured[:15], 0.1), stored(measured, 0.1)
    both["deflection"][15:] += 1e-3
    both["gap"][15] = True
    both["encoder"]["mean"][15, X], both["encoder"]["covariance"][15] = measured[15] + 1e-3, np.eye(MOTION)
    for steps in (before, both):
        mean, covariance = np.zeros((MOTION, 1)), np.diag([1e-8, 1e-6, 1e-4, 1e-2])
        mean[X] = 0.01
        smooth(steps, steps.size, mean, covariance)
    assert np.array_equal(both["smoothed"][:15], before["smoothed"])
    assert both["smoothed"][16:, X] == pytest.approx(measured[16:] + 1e-3, abs=5e-5)
