# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""State of the preprocessing: one record in an array of one element, which compiled code takes.

Sub-records and arrays in it are views: `clock = state[0]["timestamps"]["clock"]`.
"""

import numpy as np
from vsa_estimator.tuning.preprocessing import PERIOD_WINDOW

# Stamps of type f8 count from the first stamp, except in STUCK, BURST and CHECKS, where they are rounded to doubles.

VALIDATION = np.dtype([
    ("max_force", "f8"), ("max_deflection", "f8"),  # bounds of plausible magnitudes [N, m]
    ("last_stamp_ns", "i8"),  # of the last accepted sample
    ("late_run", "i8"),  # late samples in a row
])  # fmt: skip

# Estimate of the sensor's sample clock; instants count from the first stamp.
CLOCK = np.dtype([
    ("period_ns", "f8"),  # inf until it is initialized
    ("instant_ns", "f8"),  # of the last sample by the sensor's clock
    ("last_stamp_ns", "f8"),
    ("intervals_ns", "f8", (PERIOD_WINDOW,)),  # from which the period is initialized
    ("interval_count", "f8"),  # behind period or jitter, bounded by their windows
    ("jitter_ns", "f8"),  # mean deviation of regular intervals
    ("queued", "f8"),  # samples of a silence that may follow it together
    ("irregular_count", "f8"),  # excess of samples that skip or repeat a period, or come later than counted
    ("was_delayed", "?"), ("relock_count", "i8"),  # returns from a delay to the clock
    # Lost samples
    ("is_counted", "?"), ("lost", "i8"),  # whether the driver counts them; those since the last sample
    ("catch_up_hold", "i8"),  # samples for which a long interval is a delay, not a loss
    ("delayed_run", "i8"),  # delayed samples in a row ...
    ("min_delay", "f8"),  # ... with at least this delay [periods] ...
    ("same_lag_run", "i8"), ("lag", "f8"),  # ... the last of them with the same whole number of periods
    ("off_grid_share", "f8"),  # of samples whose lag is no whole number of periods
    ("loss_rate", "f8"),  # share of the delays that were losses
    # Window of the phase-locked loop
    ("window", "f8"), ("window_count", "f8"),  # [samples]
    ("min_delay_ns", "f8", (2,)),  # of its first and second half
    ("advance_ns", "f8"),  # by which early samples have shifted the clock
    ("is_miscounted", "?"),  # a sample was too early for a wrong period
])  # fmt: skip

# Sequential test between stamps and clock, by the runs of delayed samples.
EVIDENCE = np.dtype([
    ("start_ns", "f8"), ("start_deflection", "f8"),  # of the last sample that was not delayed [ns, m]
    ("samples", "f8"),  # of the run, and sums of its products of deflection x, stamp s and instant c of the clock ...
    ("xx", "f8"), ("xs", "f8"), ("ss", "f8"), ("xc", "f8"), ("cc", "f8"),  # ... from the start [m, ns]
    ("residual", "f8"),  # mean square of a sample by the better choice, over several runs [m^2]
    ("llr", "f8"),  # log likelihood ratio of clock and stamps, with exponential fading
    ("decision", "i8"),  # 1 clock, -1 stamps, 0 undecided
])  # fmt: skip

TIMESTAMPS = np.dtype([
    ("origin_ns", "i8"),  # first stamp; 0 before it
    ("last_instant_ns", "i8"),
    ("evidence", EVIDENCE),
    ("clock", CLOCK),
])  # fmt: skip

# Configured limits of the sensor checks.
LIMITS = np.dtype([
    ("force_std", "f8"), ("deflection_std", "f8"),  # of the white noise [N, m]
    ("high_slew_force", "f8"),  # slope that leaves residual vibration [N a sample]
    ("force_change", "f8"), ("deflection_change", "f8"),  # that prove the other sensor stuck [N, m]
    ("force_limit", "f8"), ("deflection_limit", "f8"),  # of saturation [N, m]
])  # fmt: skip

# Stuck-at and run-length tests of one sensor.
STUCK = np.dtype([
    ("value", "f8"), ("since_ns", "f8"),  # last value and first stamp of its run
    ("other_min", "f8"), ("other_max", "f8"),  # of the other sensor during the run
    ("repeats", "f8"),  # of the value in a row
    ("repeat_share", "f8"), ("reversal_share", "f8"),  # of samples, leaky means
    ("is_rising", "?"),  # direction of the last change
])  # fmt: skip

# Variance-ratio test of one sensor.
NOISE = np.dtype([
    ("last", "f8"), ("before_last", "f8"), ("second_difference", "f8"),
    ("slope", "f8"), ("steepest", "f8"),  # leaky mean and its recent maximum, a sample
    ("is_vibrating", "?"),
    ("exceedance_share", "f8"), ("variance_ratio", "f8"),  # leaky means
    ("ratio", "f8"),  # standard deviation relative to the configured one; 1 unless the sensor is noisy
])  # fmt: skip

BURST = np.dtype([("last_stamp_ns", "f8"), ("interval_ns", "f8"), ("samples", "f8"), ("run", "f8")])  # mean interval

CHECKS = np.dtype([
    ("force_stuck", STUCK), ("encoder_stuck", STUCK),
    ("force_noise", NOISE), ("encoder_noise", NOISE),
    ("burst", BURST),
    ("encoder_fault_until_ns", "f8"),
])  # fmt: skip

OUTLIER = np.dtype([
    ("gate", "f8"), ("last", "f8"), ("before_last", "f8"),  # unit of the signal, like the next
    ("level", "f8"),  # running mean magnitude of the second difference
    ("run", "i8"),
])  # fmt: skip

# Fields and order of `decimator.Decimated`.
DECIMATED = np.dtype([
    ("stamp_ns", "i8"), ("deflection", "f8"), ("force", "f8"), ("samples", "i8"), ("forces", "i8"),
    ("max_increment", "f8"), ("min_increment", "f8"),
])  # fmt: skip

DECIMATOR = np.dtype([
    ("period_ns", "f8"),  # running mean of the sample period; 0 before the second sample
    ("span_ns", "f8"),  # of a block
    ("last_stamp_ns", "i8"), ("first_stamp_ns", "i8"),  # of all samples; of the block, 0 before its first sample
    ("offset_sum_ns", "i8"),  # from the first stamp
    ("deflection_sum", "f8"), ("force_sum", "f8"),  # [m, N]
    ("samples", "i8"), ("forces", "i8"),
    ("last_deflection", "f8"),  # [m]; NaN before the first sample, like the next two
    ("max_increment", "f8"), ("min_increment", "f8"),  # of the block, between successive samples [m]
    ("finished", DECIMATED, (2,)),  # by the last sample
])  # fmt: skip

PIPELINE_STATE = np.dtype([
    ("beyond_peak_speed", "?"),  # of the rod: nothing damps its vibration
    ("validation", VALIDATION),
    ("timestamps", TIMESTAMPS),
    ("limits", LIMITS),
    ("checks", CHECKS),
    ("force_outliers", OUTLIER), ("deflection_outliers", OUTLIER),
    ("decimator", DECIMATOR),
])  # fmt: skip
