"""A sudden motion after a quiet time: the density must rise at once, and settle again."""

import numpy as np
import pytest
from transmission_data import MULTISINE, TRANSMISSION_1, column, measure, run, wrong_start
from vsa_common.types import Status
from vsa_estimator.estimator import Estimator
from vsa_estimator.fault_detection.encoder_step import OffsetHypothesis
from vsa_estimator.filter.process_noise import JerkDensity

QUIET = 1.0


def test_innovations_as_they_should_be_startle_less_than_once_in_a_thousand():
    generator = np.random.default_rng(2)
    jerk = JerkDensity()
    assert sum(jerk.detect_manoeuvre(float(nis)) for nis in generator.chisquare(1, 20_000)) < 20


def test_a_burst_raises_the_density_within_three_samples_by_orders():
    jerk = JerkDensity()
    for _ in range(100):
        jerk.detect_manoeuvre(QUIET)
    before = jerk.density
    assert not jerk.detect_manoeuvre(40.0)  # a single one may be an outlier
    assert jerk.detect_manoeuvre(40.0)
    for _ in range(5):
        jerk.detect_manoeuvre(40.0)
    assert jerk.density > 1000.0 * before


def test_the_density_stays_within_the_candidates():
    jerk = JerkDensity()
    for _ in range(100):
        jerk.detect_manoeuvre(1e9)
    assert jerk.density <= 10.0


@pytest.mark.parametrize(
    ("offsets", "sets_off"),
    [((1.0, 1.6, 2.3), True), ((-1.0, -1.6, -2.3), True), ((0.5, 1.0, 1.0), False), ((1.0, -2.0, 4.0), False)],
    ids=["rod", "rod back", "encoder", "spikes"],
)
def test_a_rod_that_sets_off_is_told_from_an_encoder_that_jumped(offsets, sets_off):
    jump = OffsetHypothesis()
    for offset in offsets:
        assert not jump.is_motion_onset
        jump.reject(0.01 + 1e-4 * offset, 1e-4 * offset, 0.0)
    assert jump.is_motion_onset == sets_off


def moved_rested_moved(seconds=20.0, rest=15.0, travel=3e-3, rise=0.1, rate=500):
    """A multisine to learn from, a rest, and a brisk move: position, speed and acceleration over time."""
    t = np.arange(round((seconds + rest + 1.0) * rate)) / rate
    centre, tones = MULTISINE
    fade = np.clip((t - seconds) / 0.5, 0.0, 1.0)
    x = centre + (1.0 - fade**3 * (10.0 - 15.0 * fade + 6.0 * fade**2)) * sum(
        amplitude * np.sin(2.0 * np.pi * frequency * t) for amplitude, frequency in tones
    )
    step = np.clip((t - seconds - rest) / rise, 0.0, 1.0)
    x = x - travel * step**3 * (10.0 - 15.0 * step + 6.0 * step**2)
    return t, x, np.gradient(x, t), np.gradient(np.gradient(x, t), t)


def test_a_rod_that_sets_off_after_a_long_rest_is_followed():
    t, *motion = moved_rested_moved()
    recording = measure(TRANSMISSION_1, t, *motion)
    estimates = run(Estimator(wrong_start(TRANSMISSION_1)), recording)
    late = t > 34.0
    status, resets = column(estimates, "status"), column(estimates, "reset_count")
    assert Status.DEGRADED not in status[late]
    assert (status[late] != Status.VALID).sum() < 25  # 50 ms, in which nobody can tell where the rod is
    assert resets[-1] == resets[late][0]
    error = np.abs(column(estimates, "stiffness") / recording.stiffness - 1.0)
    std = np.sqrt(column(estimates, "stiffness_variance")) / recording.stiffness
    assert error[t > 35.2].max() < 0.02
    assert (error[late] > np.maximum(0.01, 4.0 * std[late])).sum() < 10  # 20 ms at the onset
