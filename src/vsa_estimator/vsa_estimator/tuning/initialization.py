# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tuned constants of `vsa_estimator.initialization`."""

from functools import partial

from vsa_common.tuning import constant

_constant = partial(constant, module=__name__)

# Smoothing windows
MIN_ROWS = _constant("MIN_ROWS", 8, "1", 4, 16, "fewer rows than this do not determine six coefficients", "derivation")
MAX_ROWS = _constant("MAX_ROWS", 400, "1", 200, 800, "bounds the processing time of a regression", "ablation")
MAX_HALF_WINDOW = _constant(
    "MAX_HALF_WINDOW", 0.5, "s", 0.25, 1.0, "bounds the delay and the number of samples of a window", "ablation"
)
HALF_WINDOW_PHASE = _constant(
    "HALF_WINDOW_PHASE", 3.3, "rad", 1.65, 6.6,
    "half a window times the frequency w_c at which bias and noise of a local cubic are equal", "ablation",
)  # fmt: skip
WINDOW_TIME_RATIO = _constant(
    "WINDOW_TIME_RATIO", 1.1, "1", 1.0, 2.2, "a window that lasts longer than its samples contains a gap", "ablation"
)
MAX_RESIDUAL_RATIO = _constant(
    "MAX_RESIDUAL_RATIO", 3.0, "1", 1.5, 6.0,
    "residual variance over noise variance above which a cubic does not fit a window", "docs/decisions/0002-hand-over-and-cross-check.md, test_fast_steps_with_creep_between_them_do_not_bias_the_regression",
)  # fmt: skip
WINDOWS_PER_SLICE = _constant(
    "WINDOWS_PER_SLICE", 40, "1", 20, 80, "bounds the processing time of one slice of smoothing", "ablation"
)
NOISE_DRAWS = _constant(
    "NOISE_DRAWS", 4, "1", 2, 8, "Monte Carlo draws of noise behind the noise-induced information", "ablation"
)

# Noise of the rows
REVERSAL_FORCE = _constant(
    "REVERSAL_FORCE", 0.3, "N", 0.15, 0.6, "model error of Coulomb friction in a row at a reversal", "ablation"
)
REVERSAL_SPEED = _constant(
    "REVERSAL_SPEED", 0.3e-3, "m/s", 0.15e-3, 0.6e-3, "speed within which a row counts as at a reversal", "ablation"
)
REVERSAL_WINDOW_SHARE = _constant(
    "REVERSAL_WINDOW_SHARE", 0.7, "1", 0.35, 1.4,
    "share of the speed change over half a window that widens a reversal", "ablation",
)  # fmt: skip
COULOMB_SPEED = _constant(
    "COULOMB_SPEED", 0.1e-3, "m/s", 0.05e-3, 0.2e-3,
    "transition speed of Coulomb friction; a sharper one biases the damper of a large mass", "ablation",
)  # fmt: skip
COULOMB_NOISE_FACTOR = _constant(
    "COULOMB_NOISE_FACTOR", 1.5, "1", 0.75, 3.0,
    "share of the speed's noise variance that widens the friction transition", "ablation",
)  # fmt: skip
COULOMB_WINDOW_SHARE = _constant(
    "COULOMB_WINDOW_SHARE", 0.5, "1", 0.25, 1.0,
    "share of the speed change over half a window that widens the friction transition", "ablation",
)  # fmt: skip

# Hypothesis grid over k2
GRID_SIZE = _constant("GRID_SIZE", 15, "1", 7, 30, "hypotheses of k2 in one pass", "ablation")
GRID_HALF_WIDTH = _constant(
    "GRID_HALF_WIDTH", 0.7, "1", 0.35, 1.4, "half-width of the first grid in ln k2; a factor of two", "ablation"
)
GRID_PASSES = _constant("GRID_PASSES", 6, "1", 3, 12, "refinements until weights and v* are consistent", "ablation")
GRID_ZOOM_STDS = _constant(
    "GRID_ZOOM_STDS", 3.0, "1", 1.5, 6.0, "half-width of the next grid in standard deviations of ln k2", "ablation"
)
GRID_ZOOM_STEPS = _constant(
    "GRID_ZOOM_STEPS", 0.3, "1", 0.15, 0.6, "half-width that the next grid adds, in steps of this one", "ablation"
)
SECOND_START_RATIO = _constant(
    "SECOND_START_RATIO", 0.5, "1", 0.25, 1.0, "v* of the second grid over that of the prior", "ablation"
)
START_STIFFNESS = _constant(
    "START_STIFFNESS", 1e4, "N/m", 5e3, 2e4, "slope by which noise enters a row before the first pass", "ablation"
)
START_DAMPING = _constant(
    "START_DAMPING", 4e3, "N s/m", 2e3, 8e3, "slope by which noise enters a row before the first pass", "ablation"
)
MAX_DAMPING = _constant(
    "MAX_DAMPING", 2e4, "N s/m", 1e4, 4e4, "upper bound of the damping in the rows' covariance", "ablation"
)
DAMPING_STDS = _constant(
    "DAMPING_STDS", 2.0, "1", 1.0, 4.0,
    "margin of the damping in the rows' covariance; without it a fit with too small a damping is overconfident",
    "ablation",
)  # fmt: skip
COVARIANCE_INFLATION = _constant(
    "COVARIANCE_INFLATION", 1.2, "1", 1.0, 2.4,
    "variance factor for the model error of the damper's clip and of smoothing", "ablation",
)  # fmt: skip
MAX_NOISE_INFORMATION = _constant(
    "MAX_NOISE_INFORMATION", 0.1, "1", 0.05, 0.2,
    "share of noise in the information of a direction above which the direction stays at the prior", "ablation",
)  # fmt: skip
MAX_NOISE_INFORMATION_UNCONSTRAINED = _constant(
    "MAX_NOISE_INFORMATION_UNCONSTRAINED", 0.25, "1", 0.125, 0.5,
    "share of noise above which a direction is excluded from the comparison of hypotheses too", "ablation",
)  # fmt: skip

# Successive fits and hand-over
MAX_STEP_STDS = _constant(
    "MAX_STEP_STDS", 2.5, "1", 1.25, 5.0,
    "step of stiffness or k2 between successive fits, in standard deviations, that chance does not explain", "ablation",
)  # fmt: skip
INCONSISTENCY_DECAY = _constant(
    "INCONSISTENCY_DECAY", 0.7, "1", 0.35, 1.0, "share of a step inconsistency that remains one fit later", "ablation"
)
MIN_SAMPLES = _constant("MIN_SAMPLES", 40, "1", 20, 80, "samples before the first regression", "ablation")
SLICE_RATE = _constant(
    "SLICE_RATE", 300.0, "1/s", 150.0, 600.0, "a regression ends before the next refresh, at an even load", "ablation"
)
MAX_SLICES = _constant("MAX_SLICES", 10.0, "1", 5.0, 20.0, "bounds the processing time of one call", "ablation")
HANDOVER_STD = _constant(
    "HANDOVER_STD", 0.1, "1", 0.05, 0.2,
    "relative standard deviation of stiffness, k2 and d1; one sweep of the stroke does not separate damper and spring",
    "test_no_fit_is_handed_over_whose_stiffness_or_damping_is_uncertain_by_a_tenth",
)  # fmt: skip
MAX_LINEARISATION_ERROR = _constant(
    "MAX_LINEARISATION_ERROR", 0.06, "1", 0.03, 0.12,
    "linearisation error over force noise up to which a filter may start", "ablation",
)  # fmt: skip
LINEARISATION_TIME = _constant(
    "LINEARISATION_TIME", 20.0, "s", 10.0, 40.0,
    "data that last longer permit a linearisation error that grows with the square of their duration", "ablation",
)  # fmt: skip

# Floors of the regression's standard deviations at hand-over.
MIN_LN_STIFFNESS_STD = _constant("MIN_LN_STIFFNESS_STD", 1e-3, "1", 1e-4, 1e-2,
    "floor of the ln stiffness, against a filter that starts too certain", "ablation")  # fmt: skip
MIN_K2_RELATIVE_STD = _constant("MIN_K2_RELATIVE_STD", 1e-3, "1", 1e-4, 1e-2,
    "floor of k2, relative", "ablation")  # fmt: skip
MIN_D1_STD = _constant("MIN_D1_STD", 1.0, "N s/m", 0.1, 10.0, "floor of d1", "ablation")  # fmt: skip
MIN_D2_STD = _constant("MIN_D2_STD", 1e5, "N s^3/m^3", 1e4, 1e6, "floor of d2", "ablation")  # fmt: skip
FIRST_CROSS_CHECK_NS = _constant("FIRST_CROSS_CHECK_NS", 8_000_000_000, "ns", 1_000_000_000, 60_000_000_000,
    "first cross-check of the filter by a regression after hand-over", "test_cross_checks_are_8_16_32_and_64_seconds_apart_and_not_rarer")  # fmt: skip
MAX_CROSS_CHECK_NS = _constant("MAX_CROSS_CHECK_NS", 64_000_000_000, "ns", 8_000_000_000, 600_000_000_000,
    "longest interval of cross-checks; it doubles from the first on", "test_cross_checks_are_8_16_32_and_64_seconds_apart_and_not_rarer")  # fmt: skip
