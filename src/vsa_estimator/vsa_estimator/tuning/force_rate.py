# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tuned constants of `vsa_estimator.force_rate`; gates are in `tuning.filter`, validity in `tuning.output`."""

from functools import partial

from vsa_common.tuning import constant

_constant = partial(constant, module=__name__)

RATE_FILTER = _constant(
    "RATE_FILTER",
    0.19,
    "s",
    0.095,
    0.38,
    "time constant of the first-order filter of the force rate",
    "derivation: 0.017 N and 0.088 N/s of section VI together",
)
MAX_LN_GROWTH = _constant(
    "MAX_LN_GROWTH",
    1.0,
    "1",
    0.5,
    2.0,
    "bound of the change of ln sigma in one step; larger steps diverge",
    "test_all_outputs_are_finite_after_outliers_and_encoder_steps",
)
START_STDS = _constant(
    "START_STDS",
    (2e-3, 5e-3, 2e-2, 1.0),
    "m/s, m/s^2, m/s^3, N/s",
    1e-3,
    2.0,
    "initial standard deviations of velocity, acceleration, jerk and filtered rate",
    "derivation: range of the rig",
)
REVERSAL_SPEED = _constant(
    "REVERSAL_SPEED", 0.3e-3, "m/s", 0.15e-3, 0.6e-3, "speed below which a reversal is possible", "ablation"
)
OFFSET_PERIOD = _constant("OFFSET_PERIOD", 0.1, "s", 0.05, 0.2, "period of the offset filter", "ablation")
OFFSET_DRIFT = _constant("OFFSET_DRIFT", 3e-5, "N^2/s", 1.5e-5, 6e-5, "drift of the force offset", "ablation")
FRICTION_DRIFT = _constant("FRICTION_DRIFT", 3e-6, "N^2/s", 1.5e-6, 6e-6, "drift of the Coulomb friction", "ablation")
JERK_BANDWIDTH = _constant(
    "JERK_BANDWIDTH", 20.0, "rad/s", 10.0, 40.0, "upper bound of the rate at which jerk changes", "ablation"
)
MAX_REVERSAL_STDS = _constant(
    "MAX_REVERSAL_STDS",
    10.0,
    "1",
    5.0,
    20.0,
    "disturbance by a reversal, in standard deviations of the rate, above which friction degrades the estimate",
    "ablation",
)
PARAMETER_DRIFT = _constant(
    "PARAMETER_DRIFT",
    (1e-6, 1e-6, 0.0, 0.0, 0.0),
    "N^2/mm^2/s, N^2 s/mm^2, ...",
    0.0,
    2e-6,
    "variance per second of [sigma D M k2 d2]; sigma and D absorb rounding of (15) and (16)",
    "ablation",
)
