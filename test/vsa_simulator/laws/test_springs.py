# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Elastic laws against their closed forms, their potentials and scipy."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator
from vsa_common.config.configuration import ConfigurationError
from vsa_simulator.laws.config import ForceLaws
from vsa_simulator.laws.springs import SPRINGS, SpringConfig
from vsa_simulator.rig.config import SecondTransmissionConfig, TransmissionConfig
from vsa_simulator.rig.transmission import elastic_scale, spring_deflection, spring_force, stiffness, transmission_from

SIDES = (TransmissionConfig(), SecondTransmissionConfig())
L = 0.020  # full stroke [m]
KINDS = ("exponential", *SPRINGS)

# Potentials over u = x / L, whose derivative is the law.
POTENTIALS = {
    "linear": lambda u: u**2 / 2,
    "quadratic": lambda u: 0.04 * u**2 + 0.92 * u**3 / 3,
    "cubic": lambda u: 0.04 * u**2 + 0.23 * u**4,
    "sinh": lambda u: np.cosh(4.4 * u) / (4.4 * np.sinh(4.4)),
    "stop": lambda u: -0.1 * (u + 1.1 * np.log(1.1 - u)),
    "softening": lambda u: (u + np.exp(-1.5 * u) / 1.5) / (1.0 - np.exp(-1.5)),
}


def transmission(kind, side=SIDES[0], **changes):
    return transmission_from(side, ForceLaws(spring=SpringConfig(kind, **changes)))


def each(function, x, p):
    return np.array([function(value, p) for value in x])


@pytest.mark.parametrize("side", SIDES, ids=("T1", "T2"))
@pytest.mark.parametrize("kind", KINDS)
def test_every_spring_has_the_force_of_the_papers_at_both_ends_and_increases_strictly(kind, side):
    p = transmission(kind, side)
    ends = side.force_offset + side.k1 * np.exp(side.k2 * np.array([0.0, L]))
    x = np.linspace(0.0, L, 1001)
    force = each(spring_force, x, p)
    np.testing.assert_allclose(force[[0, -1]], ends, rtol=1e-12)
    assert np.diff(force).min() > 0.0
    assert each(stiffness, np.linspace(-0.1 * L, 1.2 * L, 500), p).min() > 0.0


@pytest.mark.parametrize("kind", POTENTIALS)
def test_the_force_is_the_complex_step_of_the_potential_and_the_stiffness_its_second_derivative(kind):
    side, x = SIDES[1], np.linspace(0.1e-3, 20.9e-3, 347)  # off the table's nodes
    p, h = transmission(kind, side), 1e-30
    rise = side.k1 * np.expm1(side.k2 * L)
    law = (POTENTIALS[kind](x / L + 1j * h)).imag / h
    np.testing.assert_allclose(each(spring_force, x, p), side.force_offset + side.k1 + rise * law, rtol=1e-9)
    d = 1e-5
    slope = (POTENTIALS[kind](x / L + d + 1j * h) - POTENTIALS[kind](x / L - d + 1j * h)).imag / (2 * d * h)
    np.testing.assert_allclose(each(stiffness, x, p), rise / L * slope, rtol=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_the_deflection_at_a_force_is_the_inverse_of_the_force(kind):
    p = transmission(kind)
    x = np.linspace(-0.001, 0.022, 300)
    np.testing.assert_allclose(each(spring_deflection, each(spring_force, x, p), p), x, rtol=0.0, atol=1e-12)


def test_the_table_is_a_monotone_cubic_through_its_points_in_any_unit():
    table = (3.0, 3.6, 5.0, 8.5, 14.0, 23.0)
    p = transmission("tabulated", table=table)
    x = np.linspace(0.0, L, 401)
    share = (PchipInterpolator(np.linspace(0.0, L, 6), table)(x) - 3.0) / 20.0
    expected = 16.39 + 0.776 + 0.776 * np.expm1(267.2 * L) * share
    np.testing.assert_allclose(each(spring_force, x, p), expected, rtol=1e-6)


@pytest.mark.parametrize("table", [(0.0, 1.0), (0.0, 2.0, 1.0), (0.0, 1.0, 1.0)])
def test_a_table_that_does_not_increase_is_refused(table):
    with pytest.raises(ConfigurationError, match=r"spring\.table = .*: must have three values or more that increase"):
        transmission("tabulated", table=table)


def test_the_elastic_force_drifts_by_its_percentage_a_minute():
    p = transmission("linear", drift=10.0)
    assert [elastic_scale(t, p) for t in (0.0, 60.0, 150.0)] == pytest.approx([1.0, 1.1, 1.25])
    falling = transmission("linear", drift=-50.0)
    assert elastic_scale(1e4, falling) == 0.05  # never slack for good


def test_a_law_added_to_the_registry_needs_nothing_else(monkeypatch):
    def fifth(u, config):
        return 0.5 * u + 0.5 * u**5

    monkeypatch.setitem(SPRINGS, "fifth", fifth)
    p = transmission_from(replace(SIDES[0]), ForceLaws(spring=SpringConfig("fifth")))
    rise = 0.776 * np.expm1(267.2 * L)
    assert stiffness(0.012, p) == pytest.approx(rise / L * (0.5 + 2.5 * 0.6**4), rel=1e-8)
