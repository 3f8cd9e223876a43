# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Impedance of a member by differences, and the moments of the mixture."""

import numpy as np
import pytest
from vsa_estimator.general.basis import locate
from vsa_estimator.general.impedance import damping, ln_stiffness, member_impedance, mixture
from vsa_estimator.general.lack_of_fit import interpolation_variance
from vsa_estimator.general.law import LAW, general_force
from vsa_estimator.general.models import MODELS, geometry_at, members_at
from vsa_estimator.general.records import DAMPER, DAMPER_SIZE, IMPEDANCE, INTERVALS, SIZE, SPRING, SPRING_SIZE, V, X
from vsa_estimator.settings import Initial
from vsa_estimator.tuning.general import DAMPING_BIAS, LIKELIHOOD_POWER, SLOPE_STD, STIFFNESS_BIAS

GEOMETRY = geometry_at(Initial(), 0.010, 240.0)


def members():
    """All members with other coefficients than those of the prior, at 11.3 mm and 1.2 mm/s."""
    every, random = members_at(Initial(), GEOMETRY, 30.0, 1e-10), np.random.default_rng(8)
    for member in every:
        member["mean"][[X, V]] = 0.0113, 1.2e-3
        member["mean"][SPRING:] *= 1.0 + 0.1 * random.normal(size=SPRING_SIZE)
        member["mean"][DAMPER : DAMPER + DAMPER_SIZE] *= 1.0 + 0.1 * random.normal(size=DAMPER_SIZE)
        member["covariance"] *= 0.01
        member["linear"] = member["mean"]
    return every


def differences(function, member):
    """Gradient of function(member) over all states by central differences."""
    out = np.zeros(SIZE)
    for i in range(SIZE):
        step, values = 1e-4 * max(abs(member[0]["mean"][i]), 1e-3), []
        for side in (1.0, -1.0):
            moved = member.copy()
            moved["mean"][0, i] += side * step
            values.append(function(moved))
        out[i] = (values[0] - values[1]) / (2.0 * step)
    return out


def outputs(member):
    """ln stiffness, its slope, and the damping, with their gradients."""
    of_stiffness, of_slope, of_damping = np.zeros(SIZE), np.zeros(SIZE), np.zeros(SIZE)
    ln, slope = ln_stiffness(member, GEOMETRY, of_stiffness, of_slope)
    return (ln, slope, damping(member, GEOMETRY, of_damping)[0]), (of_stiffness, of_slope, of_damping)


@pytest.mark.parametrize("index", [0, 1, 3], ids=[MODELS[i].name for i in (0, 1, 3)])
def test_the_gradients_are_those_of_differences(index):
    member = members()[index : index + 1]
    _, gradients = outputs(member)
    for k in (0, 2):
        assert gradients[k] == pytest.approx(differences(lambda m, k=k: outputs(m)[0][k], member), rel=1e-3, abs=1e-6)
    by_coefficients = differences(lambda m: outputs(m)[0][1], member)[SPRING:]
    assert gradients[1][SPRING:] == pytest.approx(by_coefficients, rel=1e-4, abs=1e-6)


@pytest.mark.parametrize("state", [X, V])
def test_slopes_beyond_the_ends_are_those_of_differences(state):
    member = members()[3:4]
    end = float(GEOMETRY["origin"][0] + INTERVALS * GEOMETRY["spacing"][0])
    last_knot = (DAMPER_SIZE - 2) * float(GEOMETRY["speed_spacing"][0])
    member["mean"][0, [X, V]] = end + 1e-3, 1.1 * last_knot
    _, gradients = outputs(member)
    k = 0 if state == X else 2
    expected = differences(lambda m: outputs(m)[0][k], member)
    assert gradients[k][state] == pytest.approx(expected[state], rel=1e-4, abs=1e-3)


def test_beyond_the_ends_the_stiffness_is_uncertain_by_the_prior_of_its_slope():
    member, parts, end = members()[3:4], np.zeros(2, IMPEDANCE), float(GEOMETRY["origin"][0])
    for part, distance in zip(parts, (1e-6, 0.2), strict=True):
        member["mean"][0, X] = end - distance / Initial().k2
        member_impedance(member, GEOMETRY, part[None])
    assert np.diff(parts["ln_stiffness_variance"])[0] == pytest.approx((0.2 * SLOPE_STD) ** 2, rel=1e-6)


@pytest.mark.parametrize("index", [0, 1, 3], ids=[MODELS[i].name for i in (0, 1, 3)])
def test_stiffness_and_damping_are_the_derivatives_of_the_force(index):
    member = members()[index : index + 1]
    member["mean"][0, 8:13] = 0.0  # no friction, no delay

    def force(moved):
        moved["linear"] = moved["mean"]
        return general_force(moved, GEOMETRY, 5e-5, 1e-7, np.zeros(SIZE), np.zeros(1, LAW))

    gradient = differences(force, member)
    (ln, slope, value), _ = outputs(member)
    assert np.exp(ln) == pytest.approx(gradient[X], rel=1e-5)
    assert value == pytest.approx(gradient[V], rel=1e-4)
    beyond = member.copy()
    beyond["mean"][0, X] += 1e-6
    assert slope == pytest.approx((outputs(beyond)[0][0] - ln) / 1e-6, rel=1e-2)


def between_knots(member):
    """Variance of ln stiffness by features of the law between the knots."""
    at, geometry = member["mean"][0, X], GEOMETRY[0]
    interval, _ = locate(at, geometry["origin"], geometry["spacing"])
    relative = np.exp(outputs(member)[0][0] - geometry["growth"] * (at - geometry["reference"]))
    return interpolation_variance(member, interval) / relative**2


def test_the_variances_are_quadratic_forms_of_covariance_and_bias():
    member, out = members()[3:4], np.zeros(1, IMPEDANCE)
    member["bias"][0] = 0.1 * np.sqrt(np.diag(member["covariance"][0]))
    member_impedance(member, GEOMETRY, out)
    _, gradients = outputs(member)
    for name, gradient in zip(("ln_stiffness", "slope", "damping"), gradients, strict=True):
        expected = gradient @ member["covariance"][0] @ gradient + (gradient @ member["bias"][0]) ** 2
        expected += between_knots(member) if name == "ln_stiffness" else 0.0
        assert out[name + "_variance"][0] == pytest.approx(expected, rel=1e-9)


def test_the_variances_grow_with_the_lack_of_fit():
    member, plain, inflated = members()[1:2], np.zeros(1, IMPEDANCE), np.zeros(1, IMPEDANCE)
    member_impedance(member, GEOMETRY, plain)
    member["stiffness_inflation"], member["damping_inflation"] = 5.0, 3.0
    member_impedance(member, GEOMETRY, inflated)
    between = between_knots(member)
    expected = between + 5.0 * (plain["ln_stiffness_variance"] - between)
    assert inflated["ln_stiffness_variance"] == pytest.approx(expected)
    assert inflated["damping_variance"] == pytest.approx(3.0 * plain["damping_variance"])


def test_the_mixture_has_the_moments_of_its_members():
    every, probabilities, out = members(), np.empty(len(MODELS)), np.zeros(1, IMPEDANCE)
    every["ln_likelihood"] = np.linspace(0.0, -3.0, len(MODELS))
    mixture(every, GEOMETRY, probabilities, out)
    weights = np.exp(LIKELIHOOD_POWER * every["ln_likelihood"]) * np.array([model.prior for model in MODELS])
    weights /= weights.sum()
    assert probabilities == pytest.approx(weights)
    parts = np.zeros(len(MODELS), IMPEDANCE)
    for m in range(len(MODELS)):
        member_impedance(every[m : m + 1], GEOMETRY, parts[m : m + 1])
    for name in ("ln_stiffness", "damping"):
        mean = weights @ parts[name]
        assert out[name][0] == pytest.approx(mean)
        second = weights @ (parts[name + "_variance"] + parts[name] ** 2)
        expected = second - mean**2 + systematic_square(name, weights @ parts["rest_damping"])
        assert out[name + "_variance"][0] == pytest.approx(expected, rel=1e-6)


def systematic_square(name, rest_damping):
    return STIFFNESS_BIAS**2 if name == "ln_stiffness" else (DAMPING_BIAS * rest_damping) ** 2


def test_an_unlikely_member_is_left_out():
    every, probabilities, out = members(), np.empty(len(MODELS)), np.zeros(1, IMPEDANCE)
    every["ln_likelihood"] = -20.0 / LIKELIHOOD_POWER
    every["ln_likelihood"][1] = 0.0
    mixture(every, GEOMETRY, probabilities, out)
    alone = np.zeros(1, IMPEDANCE)
    member_impedance(every[1:2], GEOMETRY, alone)
    assert probabilities[1] > 0.9999
    assert out["ln_stiffness"] == pytest.approx(alone["ln_stiffness"], rel=1e-12)
    expected = alone["ln_stiffness_variance"] + STIFFNESS_BIAS**2
    assert out["ln_stiffness_variance"] == pytest.approx(expected, rel=1e-9)
