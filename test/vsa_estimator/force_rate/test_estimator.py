# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Formulation `force_rate`: accuracy without friction, degradation with friction."""

from dataclasses import replace

import numpy as np
import pytest
from transmission_data import MULTISINE, SLOW, TRANSMISSION_1, column, record, run
from vsa_common.config.configuration import build
from vsa_common.types import ResetReason, Status
from vsa_estimator.force_rate.estimator import ForceRateEstimator
from vsa_estimator.formulations import create_estimator
from vsa_estimator.settings import EstimatorConfig

FRICTIONLESS = replace(TRANSMISSION_1, coulomb_friction=0.0)


def good_start(seed: int = 0) -> EstimatorConfig:
    """Start values within a few per cent, as `identify` writes them."""
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
def test_without_friction_k2_of_a_slow_motion_is_within_three_tenths_of_a_percent(seed):
    data = record(FRICTIONLESS, SLOW, 60.0, seed=seed)
    estimates = run(create_estimator(good_start(seed)), data)
    assert estimates[-1].k2 == pytest.approx(FRICTIONLESS.k2, rel=0.003)
    late = slice(-1800, None)
    np.testing.assert_allclose(column(estimates, "stiffness")[late], data.stiffness[late], rtol=0.01)
    assert estimates[-1].status is Status.VALID
    assert estimates[-1].force_offset == pytest.approx(FRICTIONLESS.force_offset, abs=0.2)


def test_friction_is_the_reason_of_a_degraded_estimate():
    initial = replace(good_start().initial, coulomb_friction=0.3, coulomb_friction_std=0.3)
    estimator = ForceRateEstimator(replace(good_start(), initial=initial))
    estimates = run(estimator, record(TRANSMISSION_1, SLOW, 60.0))
    assert "Coulomb friction" in estimator.state().reason
    assert estimates[-1].status is not Status.VALID
    assert not estimates[-1].damping_valid


def test_all_outputs_are_finite_after_outliers_and_encoder_steps():
    data = record(TRANSMISSION_1, MULTISINE, 10.0)
    data.force[300] += 50.0
    data.deflection[500:] += 2e-3
    estimates = run(ForceRateEstimator(EstimatorConfig()), data)
    assert np.isfinite(np.array([[float(value) for value in estimate] for estimate in estimates])).all()


def test_invalid_samples_are_dropped_and_a_step_back_in_time_is_a_reset():
    estimator = ForceRateEstimator(good_start())
    assert estimator.add(2_000_000_000, 30.0, 0.010) is not None
    assert estimator.add(2_010_000_000, float("nan"), 0.010) is None
    assert estimator.add(2_000_000_000, 30.0, 0.010) is None
    estimate = estimator.add(500_000_000, 30.0, 0.010)
    assert estimate is not None
    assert (estimate.reset_count, estimate.reset_reason) == (1, ResetReason.TIME_JUMP)
    assert estimator.state().samples_dropped == 2


def test_without_samples_the_estimate_becomes_stale_and_invalid():
    estimator = ForceRateEstimator(good_start())
    run(estimator, record(FRICTIONLESS, SLOW, 5.0))
    last = estimator.state().stamp_ns
    stale = estimator.predict_to(last + 200_000_000)
    assert stale is not None
    assert stale.status is Status.STALE
    assert [stale.stiffness_valid, stale.damping_valid, stale.inertia_valid] == [False, False, False]
