# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Dry friction against its equations."""

import numpy as np
import pytest
from vsa_simulator.laws.friction import FrictionConfig, bristle_rate, friction_force, friction_from


def test_stribeck_friction_is_greater_when_slow_and_falls_to_coulomb_friction():
    p = friction_from(0.3, FrictionConfig("stribeck", dip=1.0, dip_speed=3e-4))
    v = np.array([-5e-3, -3e-4, -1e-5, 2e-4, 6e-4, 5e-3])
    expected = 0.3 * (1.0 + np.exp(-((v / 3e-4) ** 2))) * np.tanh(v / 5e-5)
    np.testing.assert_allclose([friction_force(one, 0.0, 0.0, p) for one in v], expected, rtol=1e-12)
    assert friction_force(1.5e-4, 0.0, 0.0, p) > 1.7 * friction_force(2e-3, 0.0, 0.0, p)


def test_tanh_friction_has_no_dip():
    p = friction_from(0.3, FrictionConfig("tanh"))
    assert friction_force(2e-4, 0.0, 0.0, p) == pytest.approx(0.3 * np.tanh(4.0))
    assert p.dip == 0.0


def test_lugre_friction_in_steady_sliding_is_the_stribeck_curve():
    p = friction_from(0.3, FrictionConfig("lugre"))
    for v in (2e-5, 1e-4, 1e-3):
        steady = 0.3 * (1.0 + 0.5 * np.exp(-((v / 1e-4) ** 2)))
        z = steady / 1e6
        assert bristle_rate(v, z, 3e4, p) == pytest.approx(0.0, abs=1e-12)
        assert friction_force(v, z, 0.0, p) == pytest.approx(steady)


@pytest.mark.parametrize("model", ["tanh", "stribeck", "lugre"])
def test_without_coulomb_friction_there_is_none(model):
    p = friction_from(0.0, FrictionConfig(model))
    assert friction_force(1e-3, 1e-7, 0.0, p) == 0.0
    assert bristle_rate(1e-3, 1e-7, 3e4, p) == 0.0
