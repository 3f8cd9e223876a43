# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tuned constants of the joint: unit, range, reason and evidence of each.

An `engineering choice` has neither a derivation nor an ablation.
"""

from functools import partial

from vsa_common.tuning import constant

_constant = partial(constant, module=__name__)

# impedance/reflection
VALID_SHARE = _constant("VALID_SHARE", 0.1, "1", 0.01, 1.0,
    "Share of the lowest corner frequency up to which the low-frequency expansion holds.",
    "derivation: at a tenth of the corner the damping of the expansion errs by (w / w_c)^2 = 1 %",
)  # fmt: skip
MIN_DAMPING = _constant("MIN_DAMPING", 1e-6, "N s/m", 1e-12, 1.0,
    "Keeps the corner frequency finite for a transmission without damping.",
    "engineering choice: nine orders below the damping of the paper's rig",
)  # fmt: skip

# impedance/pairing
QUEUE_LENGTH = _constant("QUEUE_LENGTH", 1000, "samples", 10, 1_000_000,
    "Bounds the memory while one transmission delivers no samples.",
    "derivation: 1 s at 1 kHz",
)  # fmt: skip
PERIOD_GAIN = _constant("PERIOD_GAIN", 1.0 / 64.0, "1", 1e-4, 1.0,
    "Gain of the period, skew and jitter estimates per sample: averages over about 64 samples.",
    "derivation: relative variance of the period estimate is gain / (2 - gain) of that of one step",
)  # fmt: skip
PERIOD_STEP_CAP = _constant("PERIOD_STEP_CAP", 10.0, "periods", 1.0, 1e4,
    "Caps a stamp step in the period estimate, because a gap contains little information about the period.",
    "derivation: with PERIOD_GAIN a gap changes the period by at most (10 - 1) / 64 = 14 %",
)  # fmt: skip
RATE_RATIO = _constant("RATE_RATIO", 1.5, "1", 1.0, 10.0,
    "Ratio of both sampling periods up to which samples correspond one to one.",
    "engineering choice: midway between equal rates and a ratio of two",
)  # fmt: skip
LOOKAHEAD = _constant("LOOKAHEAD", 8, "samples", 1, 1000,
    "Longest wait for the samples that decide whether a sample is lost or delayed.",
    "test: frames of an interrupted sender pair with their own samples",
)  # fmt: skip
JITTER_GATE = _constant("JITTER_GATE", 3.0, "median deviations", 0.5, 100.0,
    "Deviation of the skew within which a pair of stamps is nominal.",
    "derivation: two standard deviations of normal jitter (1 median deviation = 0.67 standard deviations)",
)  # fmt: skip
JITTER_MIN_NS = _constant("JITTER_MIN_NS", 1e4, "ns", 1.0, 1e9,
    "Lower bound of the median deviation of the skew, so that a sender without jitter does not close the gate.",
    "engineering choice",
)  # fmt: skip
JITTER_START_NS = _constant("JITTER_START_NS", 1e5, "ns", 1.0, 1e9,
    "Median deviation of the skew before the first pair.",
    "engineering choice: about one CAN frame at 1 Mbit/s",
)  # fmt: skip
TIME_RESET_NS = _constant("TIME_RESET_NS", 500_000_000, "ns", 1_000_000, 10**11,
    "Backward step of a stamp that is a reset of the clock or a restarted recording, not a reordered sample.",
    "engineering choice: five times the default `reorder_window`",
)  # fmt: skip

# impedance/fusion
STALE_PERIODS = _constant("STALE_PERIODS", 5.0, "periods", 1.0, 1000.0,
    "Periods without a pair after which the joint is STALE, where they exceed `stale_timeout`.",
    "test: a slow sensor is not stale between its samples",
)  # fmt: skip

# control/springs and control/stiffness_range
MIN_ELASTIC_FORCE = _constant("MIN_ELASTIC_FORCE", 1e-3, "N", 1e-9, 1.0,
    "Lower bound of the elastic force, which keeps logarithms finite.",
    "engineering choice: below the resolution of the force sensors",
)  # fmt: skip
STRAIGHT = _constant("STRAIGHT", 1e-6, "1", 1e-12, 1e-3,
    "Change of ln stiffness within which a segment between two knots is linear.",
    "derivation: its relative error is half of it",
)  # fmt: skip
MIN_ELASTIC_SHARE = _constant("MIN_ELASTIC_SHARE", 1e-3, "1", 1e-6, 0.1,
    "Lower bound of the stiffness below the first knot relative to that at the knot, which keeps logarithms finite.",
    "engineering choice: no command reaches below the first knot",
)  # fmt: skip
MIN_STIFFNESS_SLOPE = _constant("MIN_STIFFNESS_SLOPE", 1.0, "1/m", 1e-3, 10.0,
    "Lower bound of the slope of ln stiffness, which keeps the shares of both transmissions finite.",
    "engineering choice: 1/100 of that of the paper's rig",
)  # fmt: skip
MAX_LN_STIFFNESS = _constant("MAX_LN_STIFFNESS", 50.0, "ln(N/m)", 1.0, 700.0,
    "Magnitude of the logarithm of the stiffness beyond which an identified law is not usable.",
    "derivation: exp(50) exceeds any spring and does not overflow",
)  # fmt: skip
FORCE_BISECTIONS = _constant("FORCE_BISECTIONS", 40, "1", 10, 100,
    "Iterations of the search for the force that gives a joint stiffness.",
    "derivation: 200 N / 2^40 is below the resolution of any force",
)  # fmt: skip
RANGE_BISECTIONS = _constant("RANGE_BISECTIONS", 30, "1", 10, 100,
    "Iterations of the search for the forces at which a motor reaches its limit.",
    "derivation: 200 N / 2^30 = 0.2 uN",
)  # fmt: skip

# control/tendon_motion
LEAD_BISECTIONS = _constant("LEAD_BISECTIONS", 40, "1", 10, 100,
    "Iterations of the search for the lead that balances the torque.",
    "derivation: 0.02 m / 2^40 is below the resolution of any deflection",
)  # fmt: skip
MAX_LEAD = _constant("MAX_LEAD", 0.01, "m", 1e-4, 1.0,
    "Largest lead of one transmission over the other during co-contraction.",
    "engineering choice: half of the default `deflection_max`",
)  # fmt: skip

# control/controller
MIN_FORCE_ABOVE_OFFSET = _constant("MIN_FORCE_ABOVE_OFFSET", 0.5, "N", 1e-3, 100.0,
    "Lower bound of the force above the force offset, which keeps the logarithm of the set-point finite.",
    "engineering choice: a sixth of the default `slack_margin`",
)  # fmt: skip
MIN_STIFFNESS = _constant("MIN_STIFFNESS", 1e-3, "N m/rad", 1e-9, 1.0,
    "Lower bound of the estimated stiffness as a divisor.",
    "engineering choice: 1/300 of the lowest stiffness of the paper's rig",
)  # fmt: skip
SETTLE_BAND = _constant("SETTLE_BAND", 0.05, "ln N", 1e-3, 1.0,
    "Distance of ln(F - F0) from its set-point within which the integral trim of the stiffness is active.",
    "derivation: stiffness is proportional to F - F0, so this is 5 % of the stiffness",
)  # fmt: skip
TRIM_MAX = _constant("TRIM_MAX", 0.5, "ln(N m/rad)", 0.01, 5.0,
    "Anti-windup limit of the integral trim of the stiffness.",
    "derivation: corrects an identified k2 that errs by up to exp(0.5) - 1 = 65 %",
)  # fmt: skip
SLACK_SHARE = _constant("SLACK_SHARE", 0.5, "1", 0.0, 1.0,
    "Share of `slack_margin` below which the slack protection acts.",
    "engineering choice: the set-point keeps the full margin, transients may use half",
)  # fmt: skip
PROTECTION_GAIN = _constant("PROTECTION_GAIN", 10.0, "1/s", 0.1, 1000.0,
    "Integral gain of the slack and overload protection.",
    "derivation: time constant of 0.1 s, ten control periods",
)  # fmt: skip
PROTECTION_DECAY = _constant("PROTECTION_DECAY", 0.5, "1/s", 0.001, 100.0,
    "Decay rate of the slack and overload protection.",
    "engineering choice: time constant of 2 s, longer than a step by a factor of two",
)  # fmt: skip
DITHER_SPEED_SHARE = _constant("DITHER_SPEED_SHARE", 0.7, "1", 0.01, 1.0,
    "Peak speed of the self-excitation as a share of the speed of the greatest damper force.",
    "derivation: the cubic damper law is invertible below its maximum only; engineering choice below 1",
)  # fmt: skip

# control/clock_offset
MAX_SLEW_NS = _constant("MAX_SLEW_NS", 5_000_000, "ns", 1000, 10**9,
    "Change of the clock offset between two messages up to which it is a slew; beyond, it is a step.",
    "derivation: 500 ppm over 10 s",
)  # fmt: skip

# control/input_monitor
MEASUREMENT_TIMEOUT_NS = _constant("MEASUREMENT_TIMEOUT_NS", 100_000_000, "ns", 1_000_000, 10**10,
    "Timeout of joint angle and motor positions, which arrive at a lower rate than the estimates.",
    "requirement: the motors hold within 0.1 s of a silent input",
)  # fmt: skip
STATE_TIMEOUT_NS = _constant("STATE_TIMEOUT_NS", 250_000_000, "ns", 1_000_000, 10**10,
    "Timeout of the estimators' states.",
    "derivation: twelve periods at 50 Hz; the identified springs vary slowly",
)  # fmt: skip
LAW_TIMEOUT_NS = _constant("LAW_TIMEOUT_NS", 1_000_000_000, "ns", 1_000_000, 10**10,
    "Timeout of the estimators' states while the joint's stiffness is valid: they give the laws alone then.",
    "derivation: `law_drift` changes a law by 2 % in this time; twice the longest delay of 0.5 s beside a busy loop",
)  # fmt: skip
MAX_FUTURE_NS = _constant("MAX_FUTURE_NS", 100_000_000, "ns", 1_000_000, 10**10,
    "Stamps further in the future are of a clock that is not synchronized: their age is not observable.",
    "engineering choice: equals MEASUREMENT_TIMEOUT_NS",
)  # fmt: skip
MIN_TRANSMISSION_FORCE = _constant("MIN_TRANSMISSION_FORCE", 1.0, "N", 0.0, 100.0,
    "A smaller force is that of a slack tendon or of a disconnected sensor.",
    "engineering choice: a third of the default `slack_margin`",
)  # fmt: skip
OVERLOAD = _constant("OVERLOAD", 1.05, "1", 1.0, 2.0,
    "Ratio to `force_max` beyond which the motors hold.",
    "engineering choice: 5 % for transients",
)  # fmt: skip

# control/mode and control/supervisor
RECOVERY_NS = _constant("RECOVERY_NS", 500_000_000, "ns", 1_000_000, 10**11,
    "Greatest duration of healthy inputs before control resumes after a hold; after a shorter fault it is that of the fault.",
    "engineering choice: a longer hold ends at the measured state of the joint, whose inputs have to settle",
)  # fmt: skip
FOLLOWING_ERROR = _constant("FOLLOWING_ERROR", 0.3, "rad", 0.001, 100.0,
    "Distance of a motor from its command beyond which it does not follow.",
    "engineering choice",
)  # fmt: skip
FOLLOWING_TIMEOUT_NS = _constant("FOLLOWING_TIMEOUT_NS", 500_000_000, "ns", 1_000_000, 10**11,
    "Duration of a following error before the motors hold.",
    "engineering choice",
)  # fmt: skip

# node
RANGE_PERIOD_NS = _constant("RANGE_PERIOD_NS", 100_000_000, "ns", 1_000_000, 10**10,
    "Period at which the reachable stiffness is computed.",
    "engineering choice: the load varies slowly",
)  # fmt: skip

# experiment/excitation
ANGLE_MAX = _constant("ANGLE_MAX", 0.13, "rad", 0.001, 1.0,
    "Peak joint angle of the excitation, within which the stiffness is nearly constant.",
    "test: stiffness within 1 % and damping within 3 % of the truth",
)  # fmt: skip
SPEED_SHARE = _constant("SPEED_SHARE", 0.75, "1", 0.01, 1.0,
    "Peak speed of the excitation as a share of the speed of the greatest damper force.",
    "derivation: the cubic damper law is invertible below its maximum only; engineering choice below 1",
)  # fmt: skip

# experiment/identification
TOP_FREQUENCY = _constant("TOP_FREQUENCY", 8.0, "Hz", 0.1, 1000.0,
    "Bandwidth of the regression; above it the angle is noise.",
    "derivation: 12 times the highest line of the excitation with friction",
)  # fmt: skip
GRID_RATE = _constant("GRID_RATE", 128.0, "Hz", 1.0, 1e5,
    "Sampling rate of the band-limited period.",
    "derivation: 16 times TOP_FREQUENCY resolves the powers of the regressors",
)  # fmt: skip
MIN_SPEED = _constant("MIN_SPEED", 0.02, "rad/s", 1e-4, 10.0,
    "Slower samples are excluded, because the friction is not saturated there.",
    "test: stiffness within 1 % and damping within 3 % of the truth",
)  # fmt: skip
WIDER_TRIM = _constant("WIDER_TRIM", 1.5, "1", 1.0, 10.0,
    "Factor of MIN_SPEED in the regression variant whose difference is part of the model error.",
    "test: the error of stiffness and damping is below three standard deviations",
)  # fmt: skip
FRICTION_SPEED_MIN = _constant("FRICTION_SPEED_MIN", 0.003, "rad/s", 1e-5, 1.0,
    "Lowest saturation speed of the friction model in the grid.",
    "engineering choice",
)  # fmt: skip
FRICTION_SPEED_MAX = _constant("FRICTION_SPEED_MAX", 0.03, "rad/s", 1e-5, 1.0,
    "Highest saturation speed of the friction model in the grid.",
    "engineering choice",
)  # fmt: skip
FRICTION_SPEED_COUNT = _constant("FRICTION_SPEED_COUNT", 15, "1", 1, 1000,
    "Number of saturation speeds in the grid.",
    "derivation: adjacent speeds differ by 18 %",
)  # fmt: skip
MIN_MOVING_SHARE = _constant("MIN_MOVING_SHARE", 0.1, "1", 0.0, 1.0,
    "Least share of the period above MIN_SPEED.",
    "derivation: 256 rows of the default period for at most ten coefficients",
)  # fmt: skip
LUMPING_ERROR = _constant("LUMPING_ERROR", 1e-3, "1", 0.0, 0.1,
    "Relative error of lumping both tendons into one spring at the mean angle.",
    "test: the error of stiffness and damping is below three standard deviations",
)  # fmt: skip
CORRELATION_TIME = _constant("CORRELATION_TIME", 0.25, "s", 0.001, 100.0,
    "Duration over which residuals count as one error in the covariance (block-robust estimate).",
    "derivation: two periods of TOP_FREQUENCY",
)  # fmt: skip
