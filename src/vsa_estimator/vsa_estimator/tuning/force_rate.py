"""Tuned constants of `vsa_estimator.force_rate`."""

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
SOFT_GATE = _constant(
    "SOFT_GATE",
    16.0,
    "1",
    8.0,
    32.0,
    "NIS above which the measurement noise is inflated (M-estimation)",
    "as in formulation force",
)
HARD_GATE = _constant(
    "HARD_GATE", 100.0, "1", 50.0, 200.0, "NIS above which a measurement is an outlier", "as in formulation force"
)
MAX_LN_GROWTH = _constant(
    "MAX_LN_GROWTH", 1.0, "1", 0.5, 2.0, "bound of the change of ln sigma in one step; larger steps diverge", "ablation"
)
OFFSET_NIS_SAMPLES = _constant(
    "OFFSET_NIS_SAMPLES", 20, "1", 10, 40, "memory of the mean NIS of the offset filter, in updates", "ablation"
)
NIS_SAMPLES = _constant(
    "NIS_SAMPLES", 200, "1", 100, 400, "memory of the mean NIS of the force rate, in updates", "ablation"
)
NIS_CAP = _constant(
    "NIS_CAP", 100.0, "1", 50.0, 200.0, "one outlier does not fail the test of the mean NIS", "ablation"
)
NIS_THRESHOLD = _constant(
    "NIS_THRESHOLD", 3.0, "1", 1.5, 6.0, "mean NIS above which the model does not explain the force rate", "ablation"
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
REFRESH_PERIOD = _constant(
    "REFRESH_PERIOD", 0.5, "s", 0.25, 1.0, "period at which the jerk density is renewed", "ablation"
)
JERK_BANDWIDTH = _constant(
    "JERK_BANDWIDTH", 20.0, "rad/s", 10.0, 40.0, "upper bound of the rate at which jerk changes", "ablation"
)
GAP = _constant("GAP", 1.0, "s", 0.5, 2.0, "a longer gap of the samples restarts the filter", "ablation")
STALE_TIME = _constant(
    "STALE_TIME", 0.05, "s", 0.025, 0.1, "age of the last sample above which the status is STALE", "interface"
)
INVALID_TIME = _constant(
    "INVALID_TIME", 0.1, "s", 0.05, 0.2, "age of the last sample above which nothing is valid", "interface"
)
MAX_STIFFNESS_STD = _constant(
    "MAX_STIFFNESS_STD", 0.1, "1", 0.05, 0.2, "greatest relative standard deviation of a valid stiffness", "interface"
)
MAX_DAMPING_STD = _constant(
    "MAX_DAMPING_STD", 0.15, "1", 0.075, 0.3, "greatest relative standard deviation of a valid damping", "interface"
)
MAX_INERTIA_STD = _constant(
    "MAX_INERTIA_STD", 0.2, "1", 0.1, 0.4, "greatest relative standard deviation of a valid inertia", "interface"
)
MAX_D2_STD = _constant(
    "MAX_D2_STD", 0.25, "1", 0.125, 0.5, "greatest relative standard deviation of a valid d2", "interface"
)
MAX_K2_STD = _constant(
    "MAX_K2_STD", 0.05, "1", 0.025, 0.1, "greatest relative standard deviation of a valid k2", "interface"
)
MAX_OFFSET_STD = _constant(
    "MAX_OFFSET_STD", 1.0, "N", 0.5, 2.0, "greatest standard deviation of a valid force offset", "interface"
)
MAX_FRICTION_STD = _constant(
    "MAX_FRICTION_STD", 0.2, "N", 0.1, 0.4, "greatest standard deviation of a valid Coulomb friction", "interface"
)
MIN_DAMPING_SHARE = _constant(
    "MIN_DAMPING_SHARE",
    0.2,
    "1",
    0.1,
    0.4,
    "share of d1 below which the damping is too close to zero for a relative error",
    "ablation",
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
