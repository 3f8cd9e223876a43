# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tuned constants of `vsa_estimator.force_law`."""

from functools import partial

from vsa_common.tuning import constant

_constant = partial(constant, module=__name__)

COULOMB_SPEED = _constant(
    "COULOMB_SPEED", 0.07e-3, "m/s", 0.01e-3, 1e-3,
    "speed at which the smoothed Coulomb friction of the filter reaches 76 %", "ablation",
)  # fmt: skip
UNBOUNDED_SPEED = _constant(
    "UNBOUNDED_SPEED", 1.0, "m/s", 0.1, 10.0,
    "upper limit of the peak speed v*, which is infinite for a damper without a cubic term", "above every speed of a transmission",
)  # fmt: skip
MAX_CUBIC_STD = _constant(
    "MAX_CUBIC_STD", 0.1, "1", 0.02, 0.5,
    "standard deviation of d2, relative, up to which v* is known", "derivation: 5 % of v*, where the slope of the force is zero: 0.4 % of the greatest force",
)  # fmt: skip
PEAK_SPEED_MARGIN = _constant(
    "PEAK_SPEED_MARGIN", 0.85, "1", 0.4, 1.0,
    "share of v* up to which a damper whose v* is not determined is known", "ablation",
)  # fmt: skip
MAX_RELATIVE_SPEED_STD = _constant(
    "MAX_RELATIVE_SPEED_STD", 0.2, "1", 0.05, 1.0,
    "speed standard deviation relative to v* above which the damper is not linearised statistically", "ablation",
)  # fmt: skip
MIN_LN_STIFFNESS = _constant(
    "MIN_LN_STIFFNESS",
    -20.0,
    "1",
    -50.0,
    -5.0,
    "lower limit of ln sigma, sigma in N/m, and of k2 dx",
    "avoids underflow",
)
MAX_LN_STIFFNESS = _constant(
    "MAX_LN_STIFFNESS", 25.0, "1", 12.0, 100.0, "upper limit of ln sigma, sigma in N/m, and of k2 dx", "avoids overflow"
)
MIN_K2 = _constant("MIN_K2", 20.0, "1/m", 1.0, 100.0, "lower bound of k2 in the filter", "a spring stiffens")
MIN_D1 = _constant(
    "MIN_D1",
    50.0,
    "N s/m",
    1.0,
    500.0,
    "lower bound of d1 in the filter and in v* of a regression",
    "a damper dissipates",
)
