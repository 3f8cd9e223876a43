# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tuned constants of `vsa_estimator.filter`."""

from functools import partial

from vsa_common.tuning import constant

_constant = partial(constant, module=__name__)

# Initial state
INITIAL_SPEED_STD = _constant(
    "INITIAL_SPEED_STD", 2e-3, "m/s", 0.5e-3, 10e-3,
    "initial standard deviation of the velocity, at a start and after a gap", "ablation",
)  # fmt: skip
INITIAL_ACCELERATION_STD = _constant(
    "INITIAL_ACCELERATION_STD", 5e-3, "m/s^2", 1e-3, 50e-3,
    "initial standard deviation of the acceleration, at a start and after a gap", "ablation",
)  # fmt: skip
INITIAL_POSITION_STD_RATIO = _constant(
    "INITIAL_POSITION_STD_RATIO", 2.0, "1", 1.0, 5.0,
    "initial standard deviation of the deflection relative to the noise of the encoder", "ablation",
)  # fmt: skip
MIN_ELASTIC_FORCE = _constant(
    "MIN_ELASTIC_FORCE", 0.5, "N", 0.1, 2.0,
    "lower limit of the elastic force from which the initial stiffness follows", "keeps the logarithm finite",
)  # fmt: skip
MIN_INITIAL_COULOMB = _constant(
    "MIN_INITIAL_COULOMB", 0.02, "N", 0.005, 0.1,
    "lower limit of the Coulomb friction that an initialization hands over: at 0 the bound holds it there", "ablation",
)  # fmt: skip

# Gates
SOFT_GATE = _constant(
    "SOFT_GATE", 16.0, "1", 4.0, 64.0, "NIS above which the innovation variance is inflated (M-estimation)", "ablation"
)
HARD_GATE = _constant("HARD_GATE", 100.0, "1", 36.0, 400.0, "NIS above which a measurement is rejected", "ablation")
DEFLECTION_INFLATION = _constant(
    "DEFLECTION_INFLATION", 0.5, "1", 0.25, 2.0,
    "exponent of the inflation of a deflection: the influence stays at that of the gate", "Huber's psi function",
)  # fmt: skip
FORCE_INFLATION = _constant(
    "FORCE_INFLATION", 2.0, "1", 0.5, 4.0,
    "exponent of the inflation of a force: the influence decreases beyond the gate (redescending)", "ablation",
)  # fmt: skip

# Process noise
PARAMETER_PROCESS_NOISE = _constant(
    "PARAMETER_PROCESS_NOISE", (2.5e-11, 2.5e-7, 0.0025, 2.5e7, 0.0, 2.5e-8, 2.5e-9), "unit(z)^2/s", 0.0, 1e9,
    "random walk of s, k2, d1, d2, M, F0, d0 per second of motion: keeps the gain above zero over hours", "ablation",
)  # fmt: skip
INITIAL_JERK_DENSITY = _constant(
    "INITIAL_JERK_DENSITY", 1e-3, "m^2/s^5", 1e-5, 1e-1,
    "jerk density before the first window of likelihoods", "motion of 1 mm at 1 Hz",
)  # fmt: skip
MIN_JERK_DENSITY = _constant(
    "MIN_JERK_DENSITY", 3e-7, "m^2/s^5", 1e-8, 1e-5,
    "jerk density floor with negligible inertial force: lower values understate the variance of mass and stiffness",
    "docs/decisions/0004-jerk-density.md",
)  # fmt: skip
MIN_JERK_DENSITY_WITH_INERTIA = _constant(
    "MIN_JERK_DENSITY_WITH_INERTIA", 3e-6, "m^2/s^5", 1e-7, 1e-4,
    "jerk density floor with inertial force: higher values bias k2 upward through the noise of the position",
    "bias of 6e-5 k2 at this value, slow motion at 1 kHz",
)  # fmt: skip
PSD_SCALE = _constant(
    "PSD_SCALE", 2.2, "1", 1.0, 5.0,
    "jerk density of the filter relative to the encoder's ML estimate: the force resolves a lag that the encoder does"
    " not (1 to 2 um and 60 um/s on a motion of a few tones)", "ablation",
)  # fmt: skip
BANK_NIS_CAP = _constant(
    "BANK_NIS_CAP", 16.0, "1", 4.0, 64.0, "NIS at which one sample's evidence against a candidate ends", "ablation"
)
MANOEUVRE_NIS = _constant(
    "MANOEUVRE_NIS", 4.0, "1", 2.0, 8.0, "leaky mean of the NIS of deflections above which a manoeuvre is detected",
    "fewer than 1 in 1000 samples of chi-square noise",
)  # fmt: skip
MANOEUVRE_GAIN = _constant(
    "MANOEUVRE_GAIN", 0.3, "1", 0.1, 0.6, "gain of that mean per sample: detection within three samples", "ablation"
)
MANOEUVRE_NIS_CAP = _constant(
    "MANOEUVRE_NIS_CAP", 10.0, "1", 5.0, 20.0,
    "NIS at which one sample's evidence ends: a single outlier stays below the threshold",
    "1 + 0.3 (10 - 1) < 4",
)  # fmt: skip

# Measurement noise
NOISE_OUTLIER_RATIO = _constant(
    "NOISE_OUTLIER_RATIO", 4.0, "1", 2.0, 8.0,
    "squared differences are capped at this multiple of their mean; CAPPED_MEAN follows from it", "2 sigma Huber cap",
)  # fmt: skip
NOISE_RANGE = _constant(
    "NOISE_RANGE",
    4.0,
    "1",
    2.0,
    8.0,
    "estimated noise stays within this factor of the configured noise",
    "test_the_estimate_stays_within_a_quarter_and_four_times_of_the_configured_noise",
)
MIN_NOISE_SAMPLES = _constant(
    "MIN_NOISE_SAMPLES", 50, "1", 25, 200,
    "differences before the noise estimate replaces the configured noise", "10 % standard error",
)  # fmt: skip
MINIMUM_WINDOWS = _constant(
    "MINIMUM_WINDOWS", 120, "refreshes", 20, 600,
    "memory of the least noise estimate, 60 s: longer than a fast motion without a pause",
    "docs/decisions/0019-outliers-and-pairs.md, test_the_least_noise_of_a_minute_excludes_a_rough_motion",
)  # fmt: skip
CROSS_NOISE_SHARE = _constant(
    "CROSS_NOISE_SHARE", 0.5, "1", 0.0, 1.0,
    "share of the encoder noise through the stiffness that the gain of a force includes", "ablation",
)  # fmt: skip
REVERSAL_SPEED = _constant(
    "REVERSAL_SPEED", 0.10e-3, "m/s", 0.02e-3, 0.5e-3,
    "speed around zero within which the Coulomb law has a model error", "ablation",
)  # fmt: skip
REVERSAL_SHARE = _constant(
    "REVERSAL_SHARE", 0.3, "1", 0.0, 1.0, "standard deviation of that error relative to the friction", "ablation"
)
MIN_REVERSAL_FORCE = _constant(
    "MIN_REVERSAL_FORCE", 0.015, "N", 0.005, 0.05, "lower limit of its standard deviation", "ablation"
)
REVERSAL_TIME = _constant(
    "REVERSAL_TIME", 0.01, "s", 0.002, 0.05,
    "minimum correlation time of that error: forces within it share one error", "ablation",
)  # fmt: skip

# Observability (consider parameters)
MIN_STROKE = _constant(
    "MIN_STROKE", 0.6, "1", 0.2, 1.5, "k2 x stroke below which the spring's curvature is not observable", "ablation"
)
MIN_ACCELERATION_RATIO = _constant(
    "MIN_ACCELERATION_RATIO", 3.0, "1", 1.0, 6.0,
    "standard deviations of an acceleration that updates the mass", "errors in variables bias the mass below it",
)  # fmt: skip
MIN_INERTIAL_FORCE_RATIO = _constant(
    "MIN_INERTIAL_FORCE_RATIO", 0.2, "1", 0.05, 1.0,
    "force by the standard deviation of the mass, relative to the noise, that updates the mass", "ablation",
)  # fmt: skip
PEAK_SPEED_GATE = _constant(
    "PEAK_SPEED_GATE", 6.0, "1", 3.0, 12.0,
    "standard deviations of the speed within which it may be on either side of v*", "ablation",
)  # fmt: skip
MAX_INFORMATION_GAIN = _constant(
    "MAX_INFORMATION_GAIN", 0.1, "1", 0.02, 0.5,
    "share of the variance of d2 that one force takes there at most: it may not be the peak force", "ablation",
)  # fmt: skip

# Excitation
EXCITATION_TIME_CONSTANT = _constant(
    "EXCITATION_TIME_CONSTANT", 20.0, "s", 5.0, 80.0,
    "time constant of the travel and of the moments: one period of the slowest excitation; a regression holds two", "0.05 Hz",
)  # fmt: skip
STATIONARY_SPEED = _constant(
    "STATIONARY_SPEED", 0.1e-3, "m/s", 0.02e-3, 0.5e-3, "speed below which the transmission is stationary", "ablation"
)
STATIONARY_TIME = _constant(
    "STATIONARY_TIME", 0.5, "s", 0.1, 2.0, "time below that speed after which forces update nothing", "ablation"
)
MATCHING_TIME_CONSTANT = _constant(
    "MATCHING_TIME_CONSTANT", 10.0, "s", 2.5, 40.0, "time constant of the innovation covariance matching", "ablation"
)
MIN_MATCHING_SPEED = _constant(
    "MIN_MATCHING_SPEED", 0.3e-3, "m/s", 0.1e-3, 1e-3,
    "speed above which the form of the friction is insignificant in the innovation", "tanh(0.3/0.07) = 0.9996",
)  # fmt: skip

# Uncertainty beyond the covariance
MIN_POSITION_SHARE = _constant(
    "MIN_POSITION_SHARE", 0.4, "1", 0.1, 1.0,
    "lower limit of the position variance that counts, relative to the predicted one", "ablation",
)  # fmt: skip
MIN_VELOCITY_SHARE = _constant(
    "MIN_VELOCITY_SHARE", 0.25, "1", 0.1, 1.0,
    "lower limit of the velocity variance that counts, relative to the predicted one", "ablation",
)  # fmt: skip
MASS_STIFFNESS_AMBIGUITY = _constant(
    "MASS_STIFFNESS_AMBIGUITY", 1.5, "1", 0.5, 3.0,
    "standard deviations of the mass that count as ambiguous with the stiffness in a motion of one tone", "test_a_heavy_mass_on_one_slow_tone_has_a_consistent_interval_and_an_invalid_inertia",
)  # fmt: skip
PEAK_FRACTION = _constant(
    "PEAK_FRACTION", 0.9, "1", 0.45, 1.0, "share of v* from which a speed counts as near the peak", "ablation"
)
BEYOND_PEAK_SHARE = _constant(
    "BEYOND_PEAK_SHARE", 0.05, "1", 0.01, 0.2,
    "share of time beyond PEAK_FRACTION v* at which the peak-speed error counts in full", "ablation",
)  # fmt: skip
PEAK_SPEED_ERROR = _constant(
    "PEAK_SPEED_ERROR", 0.01, "1", 0.0025, 0.05,
    "error of d1, relative, that noise of the speed causes at the peak of the damper force", "ablation",
)  # fmt: skip

# Consistency tests of the tracker
NIS_WINDOW = _constant("NIS_WINDOW", 2.0, "s", 0.5, 8.0, "window of the NIS test", "ablation")
NIS_THRESHOLD = _constant(
    "NIS_THRESHOLD", 3.0, "1", 1.5, 6.0, "mean NIS above which the coefficients do not explain the force", "ablation"
)
NIS_CAP = _constant(
    "NIS_CAP", 10.0, "1", 4.0, 40.0,
    "upper limit of one NIS in the mean: a shock has few large innovations, wrong coefficients many", "ablation",
)  # fmt: skip
NIS_MAX_SPEED = _constant(
    "NIS_MAX_SPEED", 2.0, "1", 1.0, 4.0, "speed relative to v* above which the lag of the filter dominates the NIS",
    "ablation",
)  # fmt: skip
MAHALANOBIS_LIMIT = _constant(
    "MAHALANOBIS_LIMIT", 40.0, "1", 20.0, 80.0,
    "squared Mahalanobis distance of six coefficients from a regression's above which both are inconsistent",
    "chi-square, 6 degrees of freedom: p = 5e-7",
)  # fmt: skip
MAX_CROSS_CHECK_INERTIA = _constant(
    "MAX_CROSS_CHECK_INERTIA", 2.0, "1", 0.5, 4.0,
    "inertial force relative to the force noise above which the regression is biased by the mass", "docs/decisions/0002-hand-over-and-cross-check.md",
)  # fmt: skip
