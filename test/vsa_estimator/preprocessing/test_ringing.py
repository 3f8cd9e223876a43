"""A rod that rings with its tendon is no noise of its force sensor; noise of the sensor is."""

import numpy as np
import pytest
from vsa_estimator.preprocessing.sensor_checks import no_noise, noisiness

STD, BRISK = 0.017, 10.0  # N
RING = 0.25  # N


def listened(force, undamped=False):
    memory = no_noise()
    return [noisiness(memory, float(value), STD, BRISK * STD, undamped) for value in force]


def ringing(count, slope=0.0):
    """As it is sampled: nearly from one side to the other each time."""
    k = np.arange(count)
    return slope * k + RING * np.cos(2.6 * k)


def test_ringing_beyond_the_damper_is_tolerated_and_without_that_speed_it_is_noise():
    assert max(listened(ringing(400), undamped=True)) == 1.0
    assert max(listened(ringing(400))) > 3.0


def test_ringing_outlasts_the_brisk_motion_that_began_it():
    swept = np.concatenate([0.3 * np.arange(100), 30.0 + ringing(250)])
    assert max(listened(swept)) == 1.0
    long_after = np.concatenate([swept, 30.0 + ringing(600)])
    assert max(listened(long_after)) > 3.0


@pytest.mark.parametrize("undamped", [False, True])
def test_a_sensor_far_louder_than_any_ringing_is_named(undamped):
    noise = np.random.default_rng(1).normal(0.0, 500.0 * STD, 400)
    assert max(listened(noise, undamped)) > 1.0
