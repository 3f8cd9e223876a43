"""A sudden motion after a quiet time: the density must rise at once, and settle again."""

import numpy as np
from vsa_estimator.jerk import JerkDensity

QUIET = 1.0


def test_innovations_as_they_should_be_startle_less_than_once_in_a_thousand():
    generator = np.random.default_rng(2)
    jerk = JerkDensity()
    assert sum(jerk.startled(float(nis)) for nis in generator.chisquare(1, 20_000)) < 20


def test_a_burst_raises_the_density_within_three_samples_by_orders():
    jerk = JerkDensity()
    for _ in range(100):
        jerk.startled(QUIET)
    before = jerk.density
    assert not jerk.startled(40.0)  # a single one may be an outlier
    assert jerk.startled(40.0)
    for _ in range(5):
        jerk.startled(40.0)
    assert jerk.density > 1000.0 * before


def test_the_density_stays_within_the_candidates():
    jerk = JerkDensity()
    for _ in range(100):
        jerk.startled(1e9)
    assert jerk.density <= 10.0
