"""The paper's formulation, corrected: what it reaches without friction, and what it says with it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from transmission_data import MULTISINE, SLOW, TRANSMISSION_1, column, record, run
from vsa_common.config.configuration import build
from vsa_common.types import ResetReason, Status
from vsa_estimator.force_rate.ekf import SIZE, ForceRateFilter, OffsetFilter, R, white_snap
from vsa_estimator.force_rate.estimator import ForceRateEstimator
from vsa_estimator.formulations import create_estimator
from vsa_estimator.settings import EstimatorConfig

FRICTIONLESS = replace(TRANSMISSION_1, coulomb_friction=0.0)
STATE = np.array([0.010, 1.5e-3, 4e-3, 0.02, 7.0, 3000.0, 3200.0, 0.4, 260.0, -1.0e8])


def good_start(seed: int = 0) -> EstimatorConfig:
    """Within a few per cent, as `identify` gives it."""
    random = np.random.default_rng(seed)
    rig, values = FRICTIONLESS, {}
    for name, true, std in (
        ("k2", rig.k2, 0.03 * rig.k2), ("d1", rig.d1, 0.2 * rig.d1), ("d2", rig.d2, -0.3 * rig.d2),
        ("inertia", rig.mass, 0.3 * rig.mass), ("force_offset", rig.force_offset, 0.42),
    ):  # fmt: skip
        values |= {f"initial.{name}": true + 0.7 * std * random.uniform(-1.0, 1.0), f"initial.{name}_std": std}
    zero_friction = {"initial.coulomb_friction": 0.0, "initial.coulomb_friction_std": 0.05}
    return build(EstimatorConfig, values | zero_friction | {"formulation": "force_rate"})


@pytest.mark.parametrize("seed", range(2))
def test_without_friction_a_slow_motion_tells_k2_within_three_tenths_of_a_percent(seed):
    data = record(FRICTIONLESS, SLOW, 60.0, seed=seed)
    estimates = run(create_estimator(good_start(seed)), data)
    assert estimates[-1].k2 == pytest.approx(FRICTIONLESS.k2, rel=0.003)
    late = slice(-1800, None)
    np.testing.assert_allclose(column(estimates, "stiffness")[late], data.stiffness[late], rtol=0.01)
    assert estimates[-1].status is Status.VALID
    assert estimates[-1].force_offset == pytest.approx(FRICTIONLESS.force_offset, abs=0.2)


def test_friction_is_named_as_what_spoils_it():
    initial = replace(good_start().initial, coulomb_friction=0.3, coulomb_friction_std=0.3)
    estimator = ForceRateEstimator(replace(good_start(), initial=initial))
    estimates = run(estimator, record(TRANSMISSION_1, SLOW, 60.0))
    assert "Coulomb friction" in estimator.state().reason
    assert estimates[-1].status is not Status.VALID
    assert not estimates[-1].damping_valid


def test_every_number_is_finite_whatever_happens():
    data = record(TRANSMISSION_1, MULTISINE, 10.0)
    data.force[300] += 50.0
    data.deflection[500:] += 2e-3
    estimates = run(ForceRateEstimator(EstimatorConfig()), data)
    assert np.isfinite(np.array([[float(value) for value in estimate] for estimate in estimates])).all()


def test_the_jacobian_is_the_derivative_of_the_state_equations():
    filter = ForceRateFilter(STATE, np.ones(SIZE))
    start = filter.x.copy()
    filter._dt = 0.01
    jacobian = filter._jacobian(0.01)
    numeric = np.empty((SIZE, SIZE))
    for i in range(SIZE):
        ends = []
        step = 1e-5 * max(abs(start[i, 0]), 1e-3)
        for sign in (1.0, -1.0):
            filter.x = start.copy()
            filter.x[i, 0] += sign * step
            filter.predict_x()
            ends.append(filter.x[:, 0].copy())
        numeric[:, i] = (ends[0] - ends[1]) / (2.0 * step)
    np.testing.assert_allclose(jacobian, numeric, rtol=1e-5, atol=1e-7)


def test_stiffness_grows_with_deflection_as_the_spring_does():
    """(15) integrated: sigma exp(k2 dx), whatever the step."""
    filter = ForceRateFilter(STATE, np.ones(SIZE))
    filter.advance(0.01, 1.0)
    moved = filter.state[R.X] - STATE[R.X]
    assert filter.state[R.SIGMA] == pytest.approx(3000.0 * math.exp(260.0 * moved), rel=1e-12)
    assert filter.state[R.D] == pytest.approx(3200.0 - 3e8 * (filter.state[R.V] ** 2 - 1.5e-3**2), rel=1e-12)


def test_white_snap_adds_up_over_steps():
    """Two half steps of the chain of integrators are one whole step."""
    half, whole = white_snap(0.5), white_snap(1.0)
    f = np.array([[1.0, 0.5, 0.125, 0.125 / 6.0], [0.0, 1.0, 0.5, 0.125], [0.0, 0.0, 1.0, 0.5], [0.0, 0.0, 0.0, 1.0]])
    np.testing.assert_allclose(f @ half @ f.T + half, whole, rtol=1e-12)


def test_the_slower_filter_tells_offset_from_friction():
    offsets = OffsetFilter(10.0, 5.0, 0.0, 0.5)
    random = np.random.default_rng(1)
    for k in range(400):
        direction = 1.0 if (k // 40) % 2 else -1.0
        offsets.add(16.0 + 0.3 * direction + 0.05 * random.standard_normal(), direction, 0.05**2, 0.1)
    assert offsets.offset == pytest.approx(16.0, abs=0.02)
    assert offsets.friction == pytest.approx(0.3, abs=0.02)


def test_bad_samples_are_dropped_and_a_jump_back_starts_again():
    estimator = ForceRateEstimator(good_start())
    assert estimator.add(2_000_000_000, 30.0, 0.010) is not None
    assert estimator.add(2_010_000_000, float("nan"), 0.010) is None
    assert estimator.add(2_000_000_000, 30.0, 0.010) is None
    estimate = estimator.add(500_000_000, 30.0, 0.010)
    assert estimate is not None
    assert (estimate.reset_count, estimate.reset_reason) == (1, ResetReason.TIME_JUMP)
    assert estimator.state().samples_dropped == 2


def test_silence_is_stale_and_then_invalid():
    estimator = ForceRateEstimator(good_start())
    run(estimator, record(FRICTIONLESS, SLOW, 5.0))
    last = estimator.state().stamp_ns
    stale = estimator.predict_to(last + 200_000_000)
    assert stale is not None
    assert stale.status is Status.STALE
    assert [stale.stiffness_valid, stale.damping_valid, stale.inertia_valid] == [False, False, False]
