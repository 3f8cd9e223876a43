# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tuned constants of `vsa_estimator.general`."""

from functools import partial

from vsa_common.tuning import constant

_constant = partial(constant, module=__name__)
_MEASURED = "docs/decisions/0014-general-law.md"
_SMOOTHED = "docs/decisions/0022-smoothed-repetition.md"
_BANK = "docs/decisions/0018-evidence.md"

# Force law
STRIBECK_SPEEDS = _constant("STRIBECK_SPEEDS", (0.1e-3, 0.25e-3, 0.6e-3), "m/s", 1e-5, 1e-2,
    "widths of the Gaussians of the Stribeck dip: a factor 2.5 apart", _MEASURED)  # fmt: skip
RELAXATION_TIMES = _constant("RELAXATION_TIMES", (0.25, 0.5, 1.0, 2.0, 4.0, 8.0), "s", 0.01, 100.0,
    "time constants of the generalised Maxwell model: a factor 2 apart", _MEASURED)  # fmt: skip
STOP_TRAVELS = _constant("STOP_TRAVELS", (0.05e-3, 0.2e-3, 0.8e-3), "m", 1e-6, 1e-2,
    "travels of the stop operators of the hysteresis: a factor 4 apart", _MEASURED)  # fmt: skip
LEVEL_RATE_TIME = _constant("LEVEL_RATE_TIME", 3.0, "s", 0.3, 30.0,
    "correlation time of the level's rate", _MEASURED)  # fmt: skip
MIN_SPEED_STD = _constant("MIN_SPEED_STD", 1e-6, "m/s", 1e-8, 1e-5,
    "lower limit of the interval of the statistical linearisation", "keeps the quotient finite")  # fmt: skip
SPRING_SPACING = _constant("SPRING_SPACING", 0.5, "1/k2", 0.1, 2.0,
    "knot distance of the elastic spline", "interpolation error of exp(k2 x) below 1e-4")  # fmt: skip
SPARE_INTERVALS = _constant("SPARE_INTERVALS", 2, "1", 1, 6,
    "intervals of the elastic spline on either side of the deflections of the data",
    "test_the_spline_has_spare_intervals_on_either_side_of_the_data")  # fmt: skip
SPEED_SPACING = _constant("SPEED_SPACING", 1.0 / 7.0, "v*", 0.05, 0.5,
    "knot distance of the damper's spline; 14 splines reach 1.7 v*", _MEASURED)  # fmt: skip
SPARE_SPEED = _constant("SPARE_SPEED", 3.5e-3, "m/s", 1e-4, 0.1,
    "v* for the spacing where the initial damper has none", "v* of the paper's damper")  # fmt: skip

# Prior, relative to the initial coefficients
LEVEL_STD = _constant("LEVEL_STD", 3.0, "N", 0.3, 30.0,
    "of the level about the first force: friction and damper at the first sample", _MEASURED)  # fmt: skip
STIFFNESS_STD = _constant("STIFFNESS_STD", 1.0, "1", 0.3, 3.0,
    "of the stiffness at the reference, relative: wrong by a factor of two", "required start values")  # fmt: skip
SLOPE_STD = _constant("SLOPE_STD", 0.5, "1", 0.1, 2.0,
    "of the slope of the stiffness relative to the exponential, in k2", _MEASURED)  # fmt: skip
SHAPE_STD = _constant("SHAPE_STD", 0.5, "1", 0.1, 2.0,
    "of the shape of the stiffness relative to the exponential (Matern 5/2)", _MEASURED)  # fmt: skip
SHAPE_LENGTH = _constant("SHAPE_LENGTH", 1.33, "1/k2", 0.3, 5.0,
    "correlation length of the shape", _MEASURED)  # fmt: skip
DAMPER_SHAPE_STD = _constant("DAMPER_SHAPE_STD", 0.6, "d1", 0.1, 2.0,
    "of the shape of the damping over the speed (Matern 5/2)", _MEASURED)  # fmt: skip
DAMPER_SHAPE_LENGTH = _constant("DAMPER_SHAPE_LENGTH", 0.71, "v*", 0.2, 3.0,
    "correlation length of that shape", _MEASURED)  # fmt: skip
CUBIC_STD = _constant("CUBIC_STD", 2.0, "initial.d2_std", 0.5, 5.0,
    "of d2, in the configured standard deviation: other springs hide it longer", _MEASURED)  # fmt: skip
DELAY_STD = _constant("DELAY_STD", 4e-3, "s", 1e-4, 0.05,
    "of the delay between force and encoder", "filters and buses of sensors: up to 10 ms")  # fmt: skip
MAX_DELAY = _constant("MAX_DELAY", 0.03, "s", 0.01, 0.1,
    "limit of the delay: the second-order expansion fails beyond it", "derivation: a delay of 1/10 rad at 0.5 Hz")  # fmt: skip
STRIBECK_STD = _constant("STRIBECK_STD", 0.7, "initial.coulomb_friction_std", 0.1, 3.0,
    "of each amplitude of the Stribeck dip", _MEASURED)  # fmt: skip
RELAXATION_STD = _constant("RELAXATION_STD", 0.07, "1", 0.01, 0.5,
    "of the share of each relaxation time", _MEASURED)  # fmt: skip
HYSTERESIS_STD = _constant("HYSTERESIS_STD", 1.0, "initial.coulomb_friction_std", 0.1, 10.0,
    "of the amplitude of each stop operator", _MEASURED)  # fmt: skip
INITIAL_JERK_STD = _constant("INITIAL_JERK_STD", 3e-2, "m/s^3", 1e-3, 1.0,
    "initial standard deviation of the jerk", "motion of 0.1 mm at 1 Hz")  # fmt: skip

# Updates
MOTION_GATE = _constant("MOTION_GATE", 36.0, "1", 16.0, 100.0,
    "NIS of a deflection above which a member's motion is set to that of the encoder", "6 standard deviations")  # fmt: skip
MIN_LEVEL_RATIO = _constant("MIN_LEVEL_RATIO", 0.1, "1", 0.01, 0.5,
    "lower limit of the ratio of an exponential law after and before an update", "keeps the stiffness positive")  # fmt: skip
MAX_STIFFNESS_UNCERTAINTY = _constant("MAX_STIFFNESS_UNCERTAINTY", 0.1, "1", 0.02, 0.5,
    "relative standard deviation of the stiffness up to which a force updates the motion", _MEASURED)  # fmt: skip
MAX_DAMPING_UNCERTAINTY = _constant("MAX_DAMPING_UNCERTAINTY", 0.15, "1", 0.02, 0.5,
    "relative standard deviation of the damping up to which a force updates the motion", _MEASURED)  # fmt: skip
MIN_DAMPING_SHARE = _constant("MIN_DAMPING_SHARE", 0.2, "1", 0.05, 0.5,
    "lower limit of the damping in that ratio, relative to the damping at rest", _MEASURED)  # fmt: skip
UNEXPLAINED_TIME = _constant("UNEXPLAINED_TIME", 5.0, "s", 1.0, 30.0,
    "time constant of the unexplained variance of the force", _MEASURED)  # fmt: skip
RELINEARIZATION_TIMES = _constant("RELINEARIZATION_TIMES", (2.0, 4.0, 6.0, 8.0, 10.0, 15.0), "s", 1.0, 120.0,
    "ages of the bank at which it repeats its data with the gradient of its own estimate", _SMOOTHED)  # fmt: skip
REPEATED_TIME = _constant("REPEATED_TIME", 24.0, "s", 20.0, 240.0,
    "steps that the bank keeps for repetitions, those during a repetition included", _MEASURED)  # fmt: skip
STORED_REST = _constant("STORED_REST", 2.0, "s", 0.5, 10.0,
    "of a rest, for which its steps are kept; what is longer is kept as a gap, so that rests do not displace motion", "docs/decisions/0027-rests.md")  # fmt: skip
SMOOTHING_LAG = _constant("SMOOTHING_LAG", 0.4, "s", 0.1, 2.0,
    "later deflections that smooth a motion in a repetition: 3 to 7 time constants (variance dt / density)^(1/8) at a "
    "snap density of 3e-5 to 1e-2 m^2/s^7, 0.01 mm and 100 Hz", _SMOOTHED)  # fmt: skip
STEPS_PER_SLICE = _constant("STEPS_PER_SLICE", 4, "1", 2, 100,
    "repeated steps between two samples: 0.2 to 0.3 ms", "required: no sample delayed by more than 0.5 ms")  # fmt: skip
MIN_SNAP_DENSITY = _constant("MIN_SNAP_DENSITY", 3e-5, "m^2/s^7", 1e-7, 1e-2,
    "lower limit of the snap density", _MEASURED)  # fmt: skip
SNAP_SCALE = _constant("SNAP_SCALE", 22.0, "1", 2.2, 220.0,
    "snap density of the members relative to the encoder's ML estimate: with 2.2 the velocity's error is 2.5 of its "
    "standard deviations and the damping 1 % too high, with 22 it is 1.0", _BANK)  # fmt: skip
ONSET_TIME = _constant("ONSET_TIME", 0.1, "s", 0.03, 0.5,
    "memory of the likelihoods that detect the onset of a faster motion: 10 steps", _BANK)  # fmt: skip
ONSET_EVIDENCE = _constant("ONSET_EVIDENCE", 1.0, "nat/step", 0.3, 3.0,
    "mean log likelihood ratio over that time at which a higher density is used: 10 nats in all", _BANK)  # fmt: skip
DENSITY_WINDOW = _constant("DENSITY_WINDOW", 0.5, "s", 0.1, 2.0,
    "time between two estimates of the snap density", _MEASURED)  # fmt: skip
DENSITY_WINDOWS = _constant("DENSITY_WINDOWS", 20, "1", 5, 100,
    "windows over which the likelihood of a snap density counts: 10 s", _MEASURED)  # fmt: skip

# Evidence
MAX_EVIDENCE = _constant("MAX_EVIDENCE", 20.0, "nat", 5.0, 100.0,
    "bound of the log likelihood between members: what is refuted can return within seconds", _MEASURED)  # fmt: skip
LIKELIHOOD_POWER = _constant("LIKELIHOOD_POWER", 0.2, "1", 0.05, 1.0,
    "power of the likelihood in the probabilities: innovations of a wrong law are correlated over some steps, and "
    "MAX_EVIDENCE leaves each member e^-4 of its prior odds", "docs/decisions/0017-filter-and-bank.md")  # fmt: skip
MIN_PROBABILITY = _constant("MIN_PROBABILITY", 1e-4, "1", 1e-8, 1e-2,
    "probability below which a member is left out of the mixture", "its share of a standard deviation is 1 %")  # fmt: skip
MIN_EVIDENCE_SPEED = _constant("MIN_EVIDENCE_SPEED", 2.0, "1", 1.0, 4.0,
    "speed by the encoder, in the width of the reversal of friction, below which a force is no evidence: there the "
    "variance bounds the form of the friction, and its logarithm decided between the laws", _BANK)  # fmt: skip
REFUTATION = _constant("REFUTATION", 18.0, "nat", 5.0, 20.0,
    "log likelihood below the best member at which the exponential law counts as refuted", "odds of 7e7")  # fmt: skip
ADEQUACY_TIME = _constant("ADEQUACY_TIME", 0.5, "s", 0.1, 5.0,
    "time constant of the mean NIS of the bank", "a quarter of REFUTATION_TIME")  # fmt: skip
MAX_INERTIA = _constant("MAX_INERTIA", 20.0, "kg", 10.0, 100.0,
    "mass of the bank above which it is not adequate", "required scope: a rod of 0.1 to 10 kg; twice as much")  # fmt: skip
REFUTATION_TIME = _constant("REFUTATION_TIME", 2.0, "s", 0.2, 20.0,
    "time for which the exponential law stays at that bound until it is refuted", _MEASURED)  # fmt: skip
MIN_AGE = _constant("MIN_AGE", 6.0, "s", 2.0, 30.0,
    "age of the bank from which it may refute the law: two repetitions are complete", _MEASURED)  # fmt: skip
MIN_TURNS = _constant("MIN_TURNS", 2, "1", 1, 20,
    "reversals of the motion before which the bank neither refutes the law nor is published: in a single sweep a "
    "relaxation, a damper and a spring explain the same force", _MEASURED)  # fmt: skip
TURN_TRAVEL = _constant("TURN_TRAVEL", 0.1, "1/k2", 0.02, 1.0,
    "travel before a reversal that counts: the stiffness changes by 10 %", _MEASURED)  # fmt: skip
TURN_STDS = _constant("TURN_STDS", 10.0, "1", 6.0, 50.0,
    "the same in standard deviations of the encoder", "noise alone is no reversal")  # fmt: skip
REJECTION = _constant("REJECTION", 0.05, "1", 0.001, 0.5,
    "probability of the exponential law below which the bank replaces a filter that has no valid stiffness",
    "odds of 19")  # fmt: skip
ACCEPTANCE = _constant("ACCEPTANCE", 0.5, "1", 0.3, 0.95,
    "probability above which the exponential law, or all others together, are the more probable",
    "derivation: more probable than all other laws")  # fmt: skip
STIFFNESS_BIAS = _constant("STIFFNESS_BIAS", 2e-3, "1", 2e-4, 1e-2,
    "systematic error of the bank's stiffness, relative: lag of the motion, which no covariance has", _MEASURED)  # fmt: skip
DAMPING_BIAS = _constant("DAMPING_BIAS", 0.02, "damping at rest", 2e-3, 0.1,
    "the same of the damping", _MEASURED)  # fmt: skip
LAW_DISCREPANCY_STD = _constant("LAW_DISCREPANCY_STD", 0.05, "1", 0.005, 0.2,
    "prior standard deviation of the filter's ln stiffness by a wrong law that the comparison does not show",
    "docs/decisions/0017-filter-and-bank.md")  # fmt: skip
DAMPING_DISCREPANCY_STD = _constant("DAMPING_DISCREPANCY_STD", 0.1, "damping at rest", 0.02, 0.5,
    "the same of the damping", "docs/decisions/0017-filter-and-bank.md")  # fmt: skip
COMPARISON_TIME = _constant("COMPARISON_TIME", 5.0, "s", 1.0, 30.0,
    "time constant of the mean squared difference between filter and bank", _MEASURED)  # fmt: skip
COMPARISON_CAP = _constant("COMPARISON_CAP", 25.0, "1", 9.0, 100.0,
    "cap of a squared difference, normalised by its variance", "5 standard deviations: one outlier is no evidence")  # fmt: skip
DIFFERENCE_THRESHOLD = _constant("DIFFERENCE_THRESHOLD", 2.0, "1", 1.0, 5.0,
    "root mean square of the normalised difference above which filter and bank are inconsistent", _MEASURED)  # fmt: skip
MIN_GROWTH = _constant("MIN_GROWTH", 0.25, "k2", 0.05, 0.5,
    "lower limit of the growth of the exponential law, relative to the initial k2: below it the law is linear",
    "required start values: k2 within a factor of two")  # fmt: skip
KNOTS_PER_INTERVAL = _constant("KNOTS_PER_INTERVAL", 2, "1", 1, 8,
    "knots of the published elastic law in an interval of the spline",
    "derivation: ln stiffness of a linear spring is interpolated within 0.1 %")  # fmt: skip
MAX_LN_VARIANCE = _constant("MAX_LN_VARIANCE", 1.0, "1", 0.1, 4.0,
    "variance of ln stiffness at a knot above which it has no part in the fit of the growth",
    "derivation: the standard deviation of the stiffness is the stiffness, its logarithm need not exist")  # fmt: skip
MIN_LN_VARIANCE = _constant("MIN_LN_VARIANCE", 1e-8, "1", 1e-12, 1e-6,
    "added to the variance of ln stiffness at a knot in the fit of the growth", "keeps the covariance regular")  # fmt: skip
INTERPOLATION_ERROR = _constant("INTERPOLATION_ERROR", 0.015, "1", 0.003, 0.1,
    "rms error of the elastic spline between its knots over the rms fourth difference of its coefficients: that of a law "
    "whose slope has a step, fitted by least squares", _SMOOTHED)  # fmt: skip
BLOCK_LENGTHS = _constant("BLOCK_LENGTHS", (10.0, 40.0, 160.0, 640.0), "steps", 2.0, 5000.0,
    "block lengths of the lack-of-fit test: 0.1 to 6.4 s", _MEASURED)  # fmt: skip
LACK_MEMORY = _constant("LACK_MEMORY", 3000.0, "steps", 300.0, 30000.0,
    "memory of the lack-of-fit test: 30 s", _MEASURED)  # fmt: skip
SHRINKAGE = _constant("SHRINKAGE", 4.0, "blocks", 1.0, 20.0,
    "prior weight of a model without lack of fit", _MEASURED)  # fmt: skip
INFLUENCE_GAIN = _constant("INFLUENCE_GAIN", 2e-3, "1", 1e-4, 1e-1,
    "gain of the mean squared influence, which scales the blocks", "5 s at 100 Hz")  # fmt: skip
MIN_RELATIVE_STIFFNESS = _constant("MIN_RELATIVE_STIFFNESS", 1e-3, "1", 1e-6, 0.1,
    "lower limit of the stiffness relative to its coefficients", "keeps the logarithm finite")  # fmt: skip
