# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The reflection against literal figures, identities, and mass, damper, spring and tendon as a linear system."""

import numpy as np
import pytest
from vsa_joint.geometry import Joint, TendonPath
from vsa_joint.impedance.reflection import (
    Impedance,
    as_printed,
    branch_stiffness,
    inertia_terms,
    joint_stiffness,
    response,
    valid_frequency,
    virtual_work,
)

R = 0.0215
BOTH = (Impedance(2300.0, 4000.0, 0.3755), Impedance(2770.0, 3100.0, 0.2295))


def joint(first: float, second: float | None = None) -> Joint:
    return Joint((TendonPath(R, first), TendonPath(R, second or first)), damping=0.01, inertia=1e-3)


def series(frequency: float, transmissions: tuple[Impedance, Impedance], geometry: Joint) -> complex:
    """Torque that turns the capstan by one radian with the motors held, from the force balances alone."""
    s = 2j * np.pi * frequency
    torque = geometry.damping * s + geometry.inertia * s**2
    for transmission, path in zip(transmissions, geometry.paths, strict=True):
        impedance = transmission.inertia * s**2 + transmission.damping * s + transmission.stiffness
        # unknowns: deflection x, tension T; impedance: Z x - 2 T = 0; tendon: 2 K x + T = K R
        k = path.tendon_stiffness
        _, tension = np.linalg.solve([[impedance, -2.0], [2.0 * k, 1.0]], [0.0, k * path.radius])
        torque += path.radius * tension
    return complex(torque)


def test_rigid_tendon_leaves_a_quarter_of_the_transmission():
    assert branch_stiffness(4000.0, 1e15) == pytest.approx(1000.0)


def test_equal_stiffness_of_tendon_and_four_fold_transmission_halves_the_tendon():
    assert branch_stiffness(4000.0, 1000.0) == 500.0


def test_response_is_that_of_transmission_and_tendon_solved_as_a_linear_system():
    geometry = Joint((TendonPath(0.0215, 1e5), TendonPath(0.03, 4e4)), 0.01, 1e-3)
    for frequency in (0.05, 0.7, 3.0, 20.0, 200.0):
        assert response(frequency, BOTH, geometry) == pytest.approx(series(frequency, BOTH, geometry), rel=1e-12)


@pytest.mark.parametrize("tendon", [2e4, 1e5, 2e6])
def test_virtual_work_is_the_taylor_series_of_the_response(tendon):
    geometry = joint(tendon, 0.7 * tendon)
    expected = virtual_work(BOTH, geometry)
    low = valid_frequency(BOTH, geometry) * 1e-2
    z = response(low, BOTH, geometry)
    w = 2 * np.pi * low
    static = response(0.0, BOTH, geometry)
    assert static.real == pytest.approx(expected.stiffness, rel=1e-12)
    assert z.imag / w == pytest.approx(expected.damping, rel=1e-4)
    assert (static - z).real / w**2 == pytest.approx(expected.inertia, rel=1e-3)


def test_the_damping_errs_by_one_percent_at_the_valid_frequency():
    geometry = joint(1e5)
    limit = valid_frequency(BOTH, geometry)
    wrong = response(limit, BOTH, geometry).imag / (2 * np.pi * limit) / virtual_work(BOTH, geometry).damping - 1
    assert 0.002 < abs(wrong) < 0.011


@pytest.mark.parametrize(("tendon", "corner"), [(2e4, 0.33e1), (1e5, 1.6e1), (2e6, 32e1)])
def test_valid_frequency_is_a_tenth_of_the_corner(tendon, corner):
    assert valid_frequency(BOTH, joint(tendon)) == pytest.approx(0.1 * corner, rel=0.05)


def test_the_printed_terms_are_twice_those_of_a_rigid_tendon():
    geometry = joint(1e12)
    right, printed = virtual_work(BOTH, geometry), as_printed(BOTH, geometry)
    assert right.stiffness == pytest.approx(printed.stiffness)
    assert printed.damping - 0.01 == pytest.approx(2.0 * (right.damping - 0.01), rel=1e-6)
    assert printed.inertia - 1e-3 == pytest.approx(2.0 * (right.inertia - 1e-3), rel=1e-4)


def test_joint_stiffness_of_two_branches_adds_with_their_radii():
    geometry = Joint((TendonPath(0.02, 1e5), TendonPath(0.03, 5e4)))
    by_hand = 0.02**2 * 2300e5 / (2300 + 4e5) + 0.03**2 * 2770 * 5e4 / (2770 + 2e5)
    assert joint_stiffness((2300.0, 2770.0), geometry) == pytest.approx(by_hand)


def test_a_soft_tendon_makes_the_apparent_inertia_negative():
    mass, maxwell = inertia_terms(BOTH, joint(2e4))
    assert maxwell > mass
    assert virtual_work(BOTH, joint(2e4)).inertia == pytest.approx(mass - maxwell + 1e-3)
    assert virtual_work(BOTH, joint(2e4)).inertia < 0
