# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tuned constants of `vsa_estimator.offline`; the evidence `interval test` is test/vsa_estimator/offline."""

from functools import partial

from vsa_common.tuning import constant

_constant = partial(constant, module=__name__)

# Segments of a recording
MAX_RATE = _constant(
    "MAX_RATE",
    100.0,
    "Hz",
    50.0,
    200.0,
    "faster recordings are averaged to about this rate; no coefficient needs more",
    "interval test",
)
SEGMENT_SAMPLES = _constant(
    "SEGMENT_SAMPLES",
    6000,
    "1",
    3000,
    12000,
    "bounds the memory of the smoother",
    "derivation: 6000 x 361 weights x 3 operators are 52 MB",
)
MIN_SAMPLES = _constant(
    "MIN_SAMPLES", 12, "1", 6, 24, "fewer samples do not determine seven coefficients", "derivation"
)
HELD_SHARE = _constant(
    "HELD_SHARE",
    0.2,
    "1",
    0.1,
    0.4,
    "share of repeated forces above which the force sensor is slower than the recording",
    "interval test",
)
REVERSAL_SPEED = _constant(
    "REVERSAL_SPEED", 0.2e-3, "m/s", 0.1e-3, 0.4e-3, "below this speed the Coulomb model does not hold", "interval test"
)
REVERSAL_SHARE = _constant(
    "REVERSAL_SHARE",
    0.15,
    "1",
    0.075,
    0.3,
    "the same as a share of the recording's high speeds; the lesser counts",
    "interval test",
)
SIGN_STDS = _constant(
    "SIGN_STDS",
    3.0,
    "1",
    1.5,
    6.0,
    "standard deviations of its noise up to which a speed has no sign",
    "ablation",
)
RESIDUAL_CAP = _constant(
    "RESIDUAL_CAP",
    3.0,
    "1",
    1.5,
    6.0,
    "standard deviations above which a residual of the smoother is capped (M-estimation)",
    "derivation: 3 sigma",
)
WINDOW_SHARE = _constant(
    "WINDOW_SHARE",
    0.6,
    "1",
    0.3,
    1.2,
    "window over the best one for deflection; slopes need less bias, and their noise is compensated",
    "interval test",
)

# Smoother
POLYNOMIAL_DEGREE = _constant(
    "POLYNOMIAL_DEGREE",
    5,
    "1",
    3,
    7,
    "the curvature of a quintic has a bias of fourth order in the window",
    "derivation",
)
EVEN_TOLERANCE = _constant(
    "EVEN_TOLERANCE",
    1e-2,
    "1",
    5e-3,
    2e-2,
    "steps that differ by a smaller share share one set of weights",
    "derivation: the weights differ by less than the noise",
)

# Identification
MIN_BENDING = _constant(
    "MIN_BENDING",
    0.05,
    "1",
    0.025,
    0.1,
    "least product of k2 and stroke in the scan; the spring is linear below it",
    "derivation",
)
MAX_BENDING = _constant(
    "MAX_BENDING",
    30.0,
    "1",
    15.0,
    60.0,
    "greatest product of k2 and stroke in the scan",
    "derivation: exp(30) exceeds the range of a force sensor",
)
INDEPENDENCE_TIME = _constant(
    "INDEPENDENCE_TIME", 2.0, "s", 1.0, 4.0, "residuals further apart count as independent", "interval test"
)
BIAS_STEPS = _constant(
    "BIAS_STEPS", 3, "1", 1, 6, "iterations of the bias correction until it is converged", "interval test"
)
WEIGHT_STEPS = _constant(
    "WEIGHT_STEPS", 3, "1", 1, 6, "iterations of the weights and of v*, which depend on the result", "interval test"
)

# Allan deviation
SLOPE_TOLERANCE = _constant(
    "SLOPE_TOLERANCE",
    0.15,
    "1",
    0.075,
    0.3,
    "deviation from the slope of white noise",
    "test of 20 records of each kind",
)
MIN_MEANS = _constant(
    "MIN_MEANS", 9, "1", 4, 18, "means in the record at the longest averaging time", "test of 20 records of each kind"
)
CONFIDENCE = _constant(
    "CONFIDENCE",
    0.999,
    "1",
    0.99,
    0.9999,
    "band that the Allan variance of white noise stays within",
    "test of 20 records of each kind",
)
BAND_MARGIN = _constant(
    "BAND_MARGIN",
    0.03,
    "1",
    0.015,
    0.06,
    "widening of that band by the error of the standard deviation",
    "test of 20 records of each kind",
)
MIN_NOISE_SAMPLES = _constant(
    "MIN_NOISE_SAMPLES",
    200,
    "1",
    100,
    400,
    "shorter records do not determine a slope",
    "derivation: five averaging times",
)
MAX_MISSING_SHARE = _constant(
    "MAX_MISSING_SHARE",
    0.02,
    "1",
    0.01,
    0.04,
    "share of missing samples above which a record does not count as even",
    "engineering choice: white noise is unaffected, drift is shortened by this share",
)
SETTLING_TIMES = _constant(
    "SETTLING_TIMES",
    8.0,
    "1",
    4.0,
    16.0,
    "time constants of the rate filter until its initial state has decayed",
    "derivation: exp(-8) is 3e-4",
)
INDEPENDENT_TIMES = _constant(
    "INDEPENDENT_TIMES",
    2.0,
    "1",
    1.0,
    4.0,
    "time constants of the rate filter between two rates that count as independent",
    "derivation: correlation exp(-2) is 0.14",
)

# Elastic law of any form
LAW_INTERVALS = _constant(
    "LAW_INTERVALS",
    16,
    "1",
    8,
    32,
    "intervals of the stiffness spline over the stroke; ln stiffness of an exponential law with a 50-fold range is met "
    "within 1e-5",
    "derivation",
)
LAW_STDS = _constant(
    "LAW_STDS",
    (3.0, 0.5),
    "1",
    0.1,
    10.0,
    "prior standard deviation of the stiffness, relative: about the mean stiffness, then about the fitted exponential law",
    "test of recordings of six springs",
)
LAW_LENGTH = _constant(
    "LAW_LENGTH", 0.25, "1", 0.1, 1.0, "correlation length of that prior, in the stroke (Matern 5/2)", "interval test"
)
MIN_STIFFNESS_SHARE = _constant(
    "MIN_STIFFNESS_SHARE",
    1e-3,
    "1",
    1e-6,
    0.1,
    "lower limit of the stiffness, in the mean stiffness",
    "keeps the logarithm finite",
)
LAW_SIGNIFICANCE = _constant(
    "LAW_SIGNIFICANCE",
    1e-6,
    "1",
    1e-12,
    1e-3,
    "probability below which the exponential law is refuted",
    "test of 20 recordings of the exponential spring and of others",
)
MIN_LAW_DEVIATION = _constant(
    "MIN_LAW_DEVIATION",
    1e-3,
    "1",
    1e-4,
    2e-2,
    "deviation of ln stiffness that unmodelled friction and delay cause",
    "test of 20 recordings of the exponential spring and of others",
)
