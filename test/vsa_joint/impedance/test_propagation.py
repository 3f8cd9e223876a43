# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Derivatives by complex step, variances by Monte Carlo."""

import numpy as np
import pytest
from vsa_joint.geometry import Joint, TendonPath, TendonPathStd
from vsa_joint.impedance.propagation import ImpedanceEstimate, consistent_branch, paper_branch, reflect_to_joint
from vsa_joint.impedance.reflection import (
    Impedance,
    as_printed,
    inertia_terms,
    valid_frequency,
    virtual_work,
)

R, SHAFT = 0.0215, {"damping": 0.01, "inertia": 1e-3}
BRANCHES = {"consistent": (consistent_branch, virtual_work), "paper": (paper_branch, as_printed)}


def reflected(values, kind):
    """K, D, J by the reflection without variances, from [sigma D M] of both transmissions, K_t and R."""
    s1, d1, m1, s2, d2, m2, tendon, radius = values
    joint = Joint((TendonPath(radius, tendon), TendonPath(radius, 0.8 * tendon)), **SHAFT)
    z = BRANCHES[kind][1]((Impedance(s1, d1, m1), Impedance(s2, d2, m2)), joint)
    return np.array([z.stiffness, z.damping, z.inertia])


@pytest.mark.parametrize("kind", ["consistent", "paper"])
def test_derivatives_agree_with_the_complex_step(kind):
    point = np.array([2300.0, 4000.0, 0.3755, 2770.0, 3100.0, 0.2295, 1e5, R], dtype=complex)
    for index in (0, 1):
        impedance = ImpedanceEstimate(*(point[3 * index : 3 * index + 3].real))
        branch = BRANCHES[kind][0](impedance, TendonPath(R, 1e5 if index == 0 else 0.8e5))
        for column in range(3):
            step = point.copy()
            step[3 * index + column] += 1e-30j
            by_step = reflected(step, kind).imag / 1e-30
            given = [branch[1][column], branch[3][column], branch[5][column]]
            assert given == pytest.approx(list(by_step), rel=1e-9, abs=1e-30)
    for column, scales in ((6, (1.0, 0.8)), (7, (1.0, 1.0))):
        step = point.copy()
        step[column] += 1e-30j
        by_step = reflected(step, kind).imag / 1e-30
        total = np.zeros(3)
        for index in (0, 1):
            branch = BRANCHES[kind][0](
                ImpedanceEstimate(*(point[3 * index : 3 * index + 3].real)), TendonPath(R, (1e5, 0.8e5)[index])
            )
            total += scales[index] * np.array([branch[1][column - 3], branch[3][column - 3], branch[5][column - 3]])
        assert total == pytest.approx(by_step, rel=1e-9, abs=1e-30)


@pytest.mark.parametrize("kind", ["consistent", "paper"])
def test_reflection_with_and_without_variances_agree(kind):
    values = (2300.0, 4000.0, 0.3755, 2770.0, 3100.0, 0.2295, 1e5, R)
    joint = Joint((TendonPath(R, 1e5), TendonPath(R, 0.8e5)), **SHAFT)
    impedances = (ImpedanceEstimate(*values[:3]), ImpedanceEstimate(*values[3:6]))
    got = reflect_to_joint(impedances, joint, (TendonPathStd(), TendonPathStd()), BRANCHES[kind][0])
    assert [got.stiffness, got.damping, got.inertia] == pytest.approx(list(reflected(values, kind)), rel=1e-12)
    plain = (Impedance(*values[:3]), Impedance(*values[3:6]))
    assert (got.mass_term, got.maxwell_term) == pytest.approx(inertia_terms(plain, joint))
    assert got.valid_frequency == pytest.approx(valid_frequency(plain, joint))
    assert got.stiffness_variance == got.damping_variance == got.inertia_variance == 0.0


def monte_carlo(relative, correlation, tendon_std, radius_std, tendon):
    """Standard deviations of K, D, J: sampled, and propagated."""
    generator = np.random.default_rng(7)
    mean = np.array([2300.0, 4000.0, 0.3755, 2770.0, 3100.0, 0.2295])
    std = mean * np.tile(relative, 2)
    covariance = np.diag(std**2)
    for offset in (0, 3):
        for a, b, rho in ((0, 1, correlation), (0, 2, -correlation), (1, 2, -0.5 * correlation)):
            covariance[offset + a, offset + b] = covariance[offset + b, offset + a] = (
                rho * std[offset + a] * std[offset + b]
            )
    impedances = generator.multivariate_normal(mean, covariance, 100_000).T
    tendons = generator.normal(tendon, tendon_std, 100_000)
    radii = generator.normal(R, radius_std, 100_000)
    values = reflected((*impedances, tendons, radii), "consistent")
    estimates = []
    for offset in (0, 3):
        c = covariance[offset : offset + 3, offset : offset + 3]
        estimates.append(ImpedanceEstimate(*mean[offset : offset + 3], *np.diag(c), c[0, 1], c[0, 2], c[1, 2]))
    joint = Joint((TendonPath(R, tendon), TendonPath(R, 0.8 * tendon)), **SHAFT)
    errors = (TendonPathStd(radius_std, tendon_std), TendonPathStd(radius_std, 0.8 * tendon_std))
    got = reflect_to_joint((estimates[0], estimates[1]), joint, errors, consistent_branch)
    return values.std(axis=1), np.sqrt([got.stiffness_variance, got.damping_variance, got.inertia_variance])


@pytest.mark.parametrize("correlation", [0.0, 0.6])
def test_variances_of_stiffness_and_damping_agree_for_ten_percent_input_errors(correlation):
    sampled, propagated = monte_carlo((0.1, 0.1, 0.1), correlation, 1e4, 0.05 * R, 1e5)
    assert propagated[:2] == pytest.approx(sampled[:2], rel=0.05)


def test_variance_of_inertia_agrees_for_five_percent_damping_and_ten_percent_tendon_errors():
    sampled, propagated = monte_carlo((0.1, 0.05, 0.1), 0.0, 1e4, 0.02 * R, 1e5)
    assert propagated[2] == pytest.approx(sampled[2], rel=0.05)
    sampled, propagated = monte_carlo((0.1, 0.05, 0.1), 0.0, 0.02 * 2e4, 0.02 * R, 2e4)
    assert propagated[2] == pytest.approx(sampled[2], rel=0.05)


def test_the_common_error_of_the_tendons_adds_coherently():
    impedances = (ImpedanceEstimate(2300.0, 4000.0, 0.3755), ImpedanceEstimate(2300.0, 4000.0, 0.3755))
    joint = Joint((TendonPath(R, 1e5), TendonPath(R, 1e5)))
    both = reflect_to_joint(impedances, joint, (TendonPathStd(0, 1e4), TendonPathStd(0, 1e4)), consistent_branch)
    one = reflect_to_joint(impedances, joint, (TendonPathStd(0, 1e4), TendonPathStd()), consistent_branch)
    assert both.stiffness_variance == pytest.approx(4.0 * one.stiffness_variance)
