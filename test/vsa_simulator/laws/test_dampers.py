# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Viscous laws against their closed forms."""

import numpy as np
import pytest
from vsa_simulator.laws.config import ForceLaws
from vsa_simulator.laws.dampers import DAMPERS, DamperConfig
from vsa_simulator.rig.config import TransmissionConfig
from vsa_simulator.rig.transmission import damper_force, damping, transmission_from

PEAK = np.sqrt(4000.0 / (3.0 * 1.089e8))  # speed of the greatest force of the paper's damper
LAWS = {  # force, damping
    "linear": (lambda v: 4000.0 * v, lambda v: 4000.0 + 0.0 * v),
    "quadratic": (
        lambda v: 1000.0 * v + (5.0 / 12.0) * 4000.0 * v * np.abs(v) / PEAK,
        lambda v: 1000.0 + (5.0 / 6.0) * 4000.0 * np.abs(v) / PEAK,
    ),
    "soft_knee": (
        lambda v: 4000.0 * PEAK / 1.5 * np.tanh(1.5 * v / PEAK),
        lambda v: 4000.0 / np.cosh(1.5 * v / PEAK) ** 2,
    ),
}


@pytest.mark.parametrize("kind", LAWS)
def test_force_and_damping_equal_their_closed_forms(kind):
    p = transmission_from(TransmissionConfig(), ForceLaws(damper=DamperConfig(kind)))
    v = np.linspace(-0.02, 0.02, 443)
    force, slope = (np.array([function(one, p) for one in v]) for function in (damper_force, damping))
    np.testing.assert_allclose(force, LAWS[kind][0](v), rtol=1e-7, atol=1e-12)
    np.testing.assert_allclose(slope, LAWS[kind][1](v), rtol=1e-5, atol=1e-2)


def test_every_law_has_a_closed_form_here():
    assert set(LAWS) == set(DAMPERS)


@pytest.mark.parametrize("kind", DAMPERS)
def test_a_damper_dissipates_at_every_speed_and_has_no_force_at_rest(kind):
    p = transmission_from(TransmissionConfig(), ForceLaws(damper=DamperConfig(kind)))
    speeds = np.concatenate([-np.geomspace(1e-7, 1.0, 50), np.geomspace(1e-7, 1.0, 50)])
    assert all(damper_force(v, p) * v > 0.0 for v in speeds)
    assert abs(damper_force(0.0, p)) < 1e-30


@pytest.mark.parametrize("kind", ["quadratic", "soft_knee"])
def test_the_force_at_the_papers_peak_speed_or_the_greatest_force_is_the_papers(kind):
    p = transmission_from(TransmissionConfig(), ForceLaws(damper=DamperConfig(kind)))
    paper = 4000.0 * PEAK - 1.089e8 * PEAK**3
    assert damper_force(PEAK if kind == "quadratic" else 0.02, p) == pytest.approx(paper, rel=1e-4)
