# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The peers on data that fit their models, and the filter of eq. (17) against its printed form."""

import numpy as np
import pytest
from vsa_bench.peers import grioli_bicchi, literal_eq17, menard, recursive_least_squares
from vsa_bench.peers.signals import RANGE, ForgettingLeastSquares, basis, second_derivative, state_variable_filter

RATE = 100.0
TIME = np.arange(6000) / RATE
SPEED_LIMIT = 3.5e-3
D1, D2 = 4000.0, -1.089e8


def spring(deflection):
    """A cubic spring, which the polynomials represent exactly."""
    return 5.0 + 2e3 * deflection + 1e7 * deflection**3


def stiffness(deflection):
    return 2e3 + 3e7 * deflection**2


@pytest.fixture(scope="module")
def data():
    phase = 2.0 * np.pi * 0.1 * TIME
    x = 0.010 + 0.003 * np.sin(phase) + 0.0005 * np.sin(3.7 * phase)
    v = np.gradient(x, 1.0 / RATE)
    return x[None], (spring(x) + D1 * v + D2 * v**3)[None], v[None]


@pytest.mark.parametrize("peer", [recursive_least_squares.fit, menard.fit])
def test_polynomial_fits_converge_to_a_polynomial_spring_and_its_damper(data, peer):
    x, force, v = data
    estimate, damping, d2 = peer(force, x, RATE, SPEED_LIMIT, 0.0)
    late = np.s_[:, 3000:5900]
    np.testing.assert_allclose(estimate[late], stiffness(x)[late], rtol=0.05)
    np.testing.assert_allclose(damping[late], (D1 + 3.0 * D2 * v**2)[late], atol=0.15 * D1)
    assert d2[0] == pytest.approx(D2, rel=0.3)


def test_the_observer_converges_to_the_stiffness_of_a_linear_spring():
    x = 0.010 + 0.004 * np.sin(2.0 * np.pi * 0.3 * TIME)[None]
    estimate = grioli_bicchi.stiffness(5.0 + 3000.0 * x, x, RATE, 0.0, -1.0)
    assert estimate[0, -1] == pytest.approx(3000.0, rel=0.01)
    assert abs(estimate[0, 5] / 3000.0 - 1.0) > 0.05


def test_the_observer_is_more_accurate_with_the_law_of_the_damper(data):
    x, force, _ = data
    with_law = grioli_bicchi.stiffness(force, x, RATE, D1, D2)
    without_law = grioli_bicchi.stiffness(force, x, RATE, 0.0, D2)
    errors = [np.abs(one - stiffness(x))[0, 2000:].mean() for one in (with_law, without_law)]
    assert errors[0] < 0.9 * errors[1]


def test_the_state_variable_filter_differentiates():
    signal = np.sin(2.0 * np.pi * 0.2 * TIME)[None]
    w = 2.0 * np.pi * 0.2
    value, slope = state_variable_filter(signal, RATE, 8.0)
    lag = 2.0 / (2.0 * np.pi * 8.0)  # delay of the filter at low frequency [s]
    late = np.s_[0, 1000:]
    np.testing.assert_allclose(value[late], np.sin(w * (TIME - lag))[1000:], atol=2e-3)
    np.testing.assert_allclose(slope[late], w * np.cos(w * (TIME - lag))[1000:], atol=3e-3)
    np.testing.assert_allclose(
        second_derivative(signal, RATE, 8.0)[late], -w * w * np.sin(w * (TIME - lag))[1000:], atol=4e-3
    )


def test_slopes_of_the_basis_are_its_derivatives():
    x = np.linspace(*RANGE, 50)
    h = 1e-7
    numeric = (basis(x + h, 4)[0] - basis(x - h, 4)[0]) / (2.0 * h)
    np.testing.assert_allclose(basis(x, 4)[1], numeric, rtol=1e-5, atol=1e-4)


def test_forgetting_least_squares_is_the_weighted_batch_solution():
    random = np.random.default_rng(1)
    rows, values = random.standard_normal((200, 3)), random.standard_normal(200)
    solver = ForgettingLeastSquares(np.zeros((1, 3)), 0.98)
    for row, value in zip(rows, values, strict=True):
        solver.add(row[None], np.array([value]))
    weights = 0.98 ** np.arange(199, -1, -1)
    prior = 0.98**200 / ForgettingLeastSquares.START * np.eye(3)
    batch = np.linalg.solve(rows.T @ (weights[:, None] * rows) + prior, rows.T @ (weights * values))
    np.testing.assert_allclose(solver.coefficients[0], batch, rtol=1e-9)


def test_eq_17_is_as_the_paper_prints_it():
    z = np.array([[10.0, 2.0, 3.0, 5.0, 4.0, 0.5, 0.25, -0.1]])
    new, jacobian, by_input = literal_eq17._step(z, np.array([7.0]), 0.01)
    row3 = 3.0 - (5.0 + 3.0 * 4.0) * 0.01 / 0.5 + 7.0 * 0.01 / 0.5
    row4 = 5.0 + 3.0 * 2.0 * 5.0 * 0.25 * 0.01
    row5 = 4.0 + 18.0 * 2.0 * 3.0 * -0.1 * 0.01
    np.testing.assert_allclose(new[0], [10.02, 2.03, row3, row4, row5, 0.5, 0.25, -0.1], rtol=1e-12)
    for i in range(8):
        step = 1e-6 * np.eye(8)[i]
        difference = (
            literal_eq17._step(z + step, np.array([7.0]), 0.01)[0]
            - literal_eq17._step(z - step, np.array([7.0]), 0.01)[0]
        )
        np.testing.assert_allclose(jacobian[0, :, i], difference[0] / 2e-6, rtol=1e-6, atol=1e-8)
    assert by_input[0, 2] == pytest.approx(0.02)


def test_eq_17_as_printed_does_not_converge():
    """From the truth itself: D T / M of 100 at 100 Hz is beyond the stability limit of an Euler step."""
    x = (0.010 + 0.003 * np.sin(2.0 * np.pi * 0.1 * TIME))[None]
    sigma = 0.776 * 267.2 * np.exp(267.2 * x)
    force = 16.39 + sigma / 267.2 + D1 * np.gradient(x[0], 0.01)[None]
    state = np.array([[x[0, 0], 0.0, 0.0, sigma[0, 0], D1, 0.3755, 267.2, D2]])
    start = literal_eq17.Start(state, 0.1 * np.abs(state) + 1e-5, 0.017, 1e-5)
    estimate = literal_eq17.run(force, x, RATE, start)[0, :, 3]
    with np.errstate(invalid="ignore"):
        assert not np.all(np.abs(estimate[-1000:] / sigma[0, -1000:] - 1.0) < 0.5)
