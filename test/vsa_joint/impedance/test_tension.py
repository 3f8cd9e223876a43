# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Split of the tensions: the internal part has no torque, and both parts add up."""

import numpy as np
import pytest
from vsa_joint.impedance.tension import internal_part, split

TENSION, RADIUS = (31.0, 12.5), (0.0215, 0.03)


def test_the_internal_part_has_no_torque_and_the_rest_no_internal_part():
    internal = internal_part(TENSION, RADIUS)
    motion = np.subtract(TENSION, internal)
    assert np.dot([RADIUS[0], -RADIUS[1]], internal) == pytest.approx(0.0, abs=1e-15)
    assert np.dot([RADIUS[0], -RADIUS[1]], motion) == pytest.approx(RADIUS[0] * TENSION[0] - RADIUS[1] * TENSION[1])
    assert np.dot(internal, motion) == pytest.approx(0.0, abs=1e-12)


def test_equal_radii_split_into_mean_and_half_difference():
    parts = split((30.0, 20.0), (0.04, 0.09), (0.02, 0.02), (0.0, 0.0))
    assert (parts.internal_force, parts.motion_torque, parts.co_contraction) == pytest.approx((25.0, 0.2, 20.0))
    assert parts.internal_force_variance == pytest.approx((0.04 + 0.09) / 4)
    assert parts.co_contraction_variance == 0.09


def test_variances_agree_with_monte_carlo():
    generator = np.random.default_rng(3)
    t1, t2 = generator.normal(TENSION[0], 0.3, 200_000), generator.normal(TENSION[1], 0.2, 200_000)
    error = generator.normal(0.0, 1.0, 200_000)
    parts = split(TENSION, (0.09, 0.04), RADIUS, (2e-4, 3e-4))
    torque = (RADIUS[0] + 2e-4 * error) * t1 - (RADIUS[1] + 3e-4 * error) * t2
    internal = np.mean(np.array(internal_part((t1, t2), RADIUS)), axis=0)
    assert parts.motion_torque_variance == pytest.approx(torque.var(), rel=0.02)
    assert parts.internal_force_variance == pytest.approx(internal.var(), rel=0.02)
