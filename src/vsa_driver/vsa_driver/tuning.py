# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tuned constants of the driver: unit, range, reason and evidence of each."""

from functools import partial

from vsa_common.tuning import constant

_constant = partial(constant, module=__name__)

# Clock of the CAN adapter

EPOCH_TOLERANCE_NS = _constant(
    "EPOCH_TOLERANCE_NS", 60_000_000_000, "ns", 10**9, 10**12,
    "A stamp this near to the host's time comes from the host's clock or a clock synchronised with it.",
    "not ablated: adapters that count from their own start differ by years",
)  # fmt: skip
MAX_AHEAD_NS = _constant(
    "MAX_AHEAD_NS", 100_000_000, "ns", 0, 10**9,
    "A stamp further ahead of the host's time is of a clock that is not synchronised: a frame is captured before its "
    "arrival.",
    "not ablated: clocks synchronised by NTP agree to some 10 ms, by PTP to less",
)  # fmt: skip
MAX_CLOCK_DRIFT = _constant(
    "MAX_CLOCK_DRIFT", 2e-4, "1", 1e-6, 1e-2,
    "The offset of an adapter's clock grows at this rate until a frame with less delay lowers it.",
    "derivation: twice the 100 ppm of a common crystal oscillator",
)  # fmt: skip

# Merging of messages

MERGE_SHARE = _constant(
    "MERGE_SHARE", 0.75, "1", 0.5, 1,
    "Frames of different messages are of one sample up to this share of the sampling period. One of the two distances "
    "between alternating frames is at most half of the period; the rest is for their jitter.",
    "derivation: middle between half of a period and one",
)  # fmt: skip

# Rolling counter

DELAY_THRESHOLD_NS = _constant(
    "DELAY_THRESHOLD_NS", 20e6, "ns", 1e5, 1e9,
    "A sample counts as delayed when the backlog of its stream exceeds this time.",
    "not ablated: diagnostics only",
)  # fmt: skip
DELAY_PERIODS = _constant(
    "DELAY_PERIODS", 5.0, "sample", 1, 100,
    "A slow stream is delayed only by more than this number of its sampling periods.",
    "not ablated: diagnostics only",
)  # fmt: skip
MAX_PAUSE_NS = _constant(
    "MAX_PAUSE_NS", 500e6, "ns", 1e6, 1e11,
    "A longer interval is a pause of the device, after which the backlog starts from zero.",
    "not ablated: diagnostics only",
)  # fmt: skip
BACKLOG_DECAY = _constant(
    "BACKLOG_DECAY", 1e-2, "1", 1e-5, 1,
    "Fraction by which the backlog decays with each sample, so that errors of the nominal period do not accumulate.",
    "not ablated: diagnostics only",
)  # fmt: skip
PERIOD_BLOCK = _constant(
    "PERIOD_BLOCK", 64, "sample", 2, 10_000,
    "Samples whose mean interval is one estimate of the nominal period.",
    "not ablated: diagnostics only",
)  # fmt: skip
PERIOD_ESTIMATES = _constant(
    "PERIOD_ESTIMATES", 5, "1", 1, 1000,
    "The nominal period is the median of this number of estimates: one block with a stall does not move it.",
    "not ablated: diagnostics only",
)  # fmt: skip
MIN_PERIOD_ESTIMATES = _constant(
    "MIN_PERIOD_ESTIMATES", 3, "1", 1, 1000,
    "Estimates of the nominal period without which no backlog is computed: the least number whose median rejects one.",
    "derivation: median of three",
)  # fmt: skip
MIN_INTERVALS = _constant(
    "MIN_INTERVALS", 100, "sample", 1, 100_000,
    "Samples after a start that are left out of the backlog, as a buffer is emptied then.",
    "not ablated: diagnostics only",
)  # fmt: skip
PERIOD_GAIN = _constant(
    "PERIOD_GAIN", 0.01, "1", 1e-5, 1,
    "Least gain of the running mean of the sampling period: it follows a change of rate within about 100 samples.",
    "derivation: time constant of an exponential mean",
)  # fmt: skip
MAX_SKIP = _constant(
    "MAX_SKIP", 64, "sample", 1, 10_000,
    "A step of the counter beyond the elapsed time by more than this has to be confirmed by a second frame.",
    "not ablated: `test_garbage_among_the_numbers_is_counted_and_nothing_else_changes`",
)  # fmt: skip
RATE_MARGIN = _constant(
    "RATE_MARGIN", 1.2, "1", 1, 10,
    "A device may send this much faster than the estimated sampling period.",
    "not ablated: covers the error of the sampling period after a change of rate",
)  # fmt: skip
MAX_REORDER = _constant(
    "MAX_REORDER", 16, "sample", 1, 10_000,
    "A frame late by up to this number of samples is out of order; a later one is of a restarted device.",
    "not ablated: buffers of CAN adapters reorder few frames",
)  # fmt: skip

# Tare

TARE_SAMPLES = _constant(
    "TARE_SAMPLES", 200, "sample", 2, 100_000,
    "Samples in the mean that becomes zero: its standard deviation is 1/14 of the sensor's noise.",
    "derivation: 1/sqrt(200); 0.2 s at 1 kHz",
)  # fmt: skip

# CAN link

BACKOFF_S = _constant(
    "BACKOFF_S", (0.05, 1.0), "s", 1e-3, 60,
    "First and longest wait before a failed bus is opened again; each wait is twice the one before.",
    "not ablated: a bus that is up again is read within 1 s",
)  # fmt: skip
POLL_S = _constant(
    "POLL_S", 0.1, "s", 1e-3, 1,
    "Timeout of a read, and with it the longest time that a stop takes.",
    "not ablated: has no effect on samples",
)  # fmt: skip
IDLE_PERIOD_S = _constant(
    "IDLE_PERIOD_S", 0.005, "s", 1e-4, 0.1,
    "Timeout of a read where an idle bus is reported, and with it the delay of a report.",
    "not ablated: well below the stale timeout of an estimator",
)  # fmt: skip

# Motors and node

MAX_POSITION_AGE_S = _constant(
    "MAX_POSITION_AGE_S", 0.5, "s", 1e-2, 60,
    "Motors are not armed on a measured position older than this; joint and motors without a sample for it are silent.",
    "not ablated: motor states are sent at 10 Hz or faster",
)  # fmt: skip
LOG_PERIOD_S = _constant(
    "LOG_PERIOD_S", 5.0, "s", 0.1, 3600,
    "Least time between two log lines of the same kind.",
    "not ablated: has no effect on samples",
)  # fmt: skip
THREAD_SWITCH_S = _constant(
    "THREAD_SWITCH_S", 0.0005, "s", 1e-5, 0.005,
    "Python's default of 5 ms lets a callback delay a sample by that time.",
    "derivation: half a sampling period at 1 kHz",
)  # fmt: skip

# Calibration against a gauge

MIN_COMMON_SAMPLES = _constant(
    "MIN_COMMON_SAMPLES", 10, "sample", 3, 10_000,
    "Fewer samples do not determine a line and its standard deviations.",
    "not ablated: a recording has thousands",
)  # fmt: skip
MIN_EXCITATION = _constant(
    "MIN_EXCITATION", 20.0, "1", 1, 1000,
    "The force has to vary by this number of standard deviations of the sensor's noise.",
    "derivation: noise in the regressor lowers the scale by a fraction of 1/20^2 = 0.25 % at most",
)  # fmt: skip
LAG_LIMIT = _constant(
    "LAG_LIMIT", 0.99, "1", 0.5, 1,
    "A best lag beyond this fraction of the range searched is at its end, and no minimum.",
    "derivation: wider than the last grid step of the search",
)  # fmt: skip
CORRELATION_TIMES = _constant(
    "CORRELATION_TIMES", 8, "1", 1, 100,
    "Bandwidth of the residuals' covariance in correlation times (fall to 1/e).",
    "derivation: coverage of the intervals in `test_intervals_hold_when_residuals_are_correlated_in_time`",
)  # fmt: skip
