# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tuned constants of the excitation: unit, range, reason and evidence of each."""

from functools import partial

from vsa_common.tuning import constant

_constant = partial(constant, module=__name__)

# model
COULOMB_SPEED = _constant("COULOMB_SPEED", 0.15e-3, "m/s", 0.01e-3, 1e-3,
    "Speed at which the smoothed Coulomb friction reaches 76 %, with the smoothing by the uncertainty of the speed.",
    "engineering choice: that of the Cramer-Rao bound of `./vsa bench estimation`",
)  # fmt: skip
MAX_EXPONENT = _constant("MAX_EXPONENT", 50.0, "ln(N/m)", 1.0, 700.0,
    "Bound of the logarithm of the stiffness in a predicted motion, against overflow.",
    "derivation: exp(50) exceeds any spring and does not overflow",
)  # fmt: skip
MIN_NOISE_STD = _constant("MIN_NOISE_STD", 1e-9, "N, m", 1e-15, 1e-3,
    "Lower bound of the noise of a sample, which keeps the information finite.",
    "engineering choice: below the resolution of any sensor",
)  # fmt: skip

# balance
NEWTON_STEPS = _constant("NEWTON_STEPS", 3, "1", 1, 20,
    "Iterations for the balance of both torques in one step of a predicted motion.",
    "derivation: the balance changes by less than 1 % in a step",
)  # fmt: skip

STATIC_BISECTIONS = _constant("STATIC_BISECTIONS", 30, "1", 10, 60,
    "Iterations for the balance of both torques at rest.",
    "derivation: 8 mm / 2^30 is below the resolution of any encoder",
)  # fmt: skip

# limits
RANGE_POINTS = _constant("RANGE_POINTS", 81, "1", 11, 10_001,
    "Mean deflections at which the limits are predicted.",
    "derivation: steps of 0.1 mm on the default travel",
)  # fmt: skip

# quantities
KNOWN_TIME = _constant("KNOWN_TIME", 0.5, "s", 0.0, 60.0,
    "Time for which a quantity must be valid within its interval to count as known.",
    "engineering choice: 25 states at 50 Hz",
)  # fmt: skip

# design
SEGMENT = _constant("SEGMENT", 10.0, "s", 0.5, 100.0,
    "Duration for which a motion is chosen; then the next one is, by the estimate of that instant.",
    "test: the simulated rig from 8 wrong starts, all known after 7.8 s in the median; 11.7 s with 5 s, 7.8 s with 20 s",
)  # fmt: skip
DESIGN_STEP = _constant("DESIGN_STEP", 0.02, "s", 1e-3, 0.1,
    "Step of the predicted motions.",
    "derivation: 20 steps a period of the fastest sine",
)  # fmt: skip

# multisine: the family
FADE_TIME = _constant("FADE_TIME", 1.5, "s", 0.0, 60.0,
    "Time in which a motion begins, or replaces the one before; a step of the speed would be a step of the damper force.",
    "engineering choice: two periods of the fast sines",
)  # fmt: skip
SLOW_FREQUENCIES = _constant("SLOW_FREQUENCIES", (0.05, 0.1, 0.15, 0.2), "Hz", 1e-3, 10.0,
    "Frequencies of the slow sine, which covers the travel.",
    "engineering choice: about the corner frequency of spring and damper, 0.1 Hz on the paper's rig",
)  # fmt: skip
TRAVEL_SHARES = _constant("TRAVEL_SHARES", (-1.0, 1.0), "1", -1.0, 1.0,
    "Greatest amplitude of the slow sine as a share of the travel; negative: it begins with less tension.",
    "engineering choice",
)  # fmt: skip
FAST_FREQUENCIES = _constant("FAST_FREQUENCIES", (0.5, 0.7, 1.0), "Hz", 1e-2, 100.0,
    "Frequencies of the first fast sine, for damper and mass.",
    "engineering choice: from that of the demo's motion to the bandwidth of position-controlled motors",
)  # fmt: skip
FAST_RATIO = _constant("FAST_RATIO", 17.0 / 7.0, "1", 1.0, 10.0,
    "Ratio of both fast frequencies.",
    "engineering choice: that of the demo's motion; no harmonic of one is the other",
)  # fmt: skip
SLOW_SHARES = _constant("SLOW_SHARES", (0.5, 0.7, 0.85), "1", 0.0, 1.0,
    "Share of the slow sine in the greatest speed.",
    "engineering choice",
)  # fmt: skip
SPEED_SHARES = _constant("SPEED_SHARES", (0.75, 1.0, 1.25), "1", 0.01, 10.0,
    "Greatest speed as a share of the speed of the greatest damper force.",
    "derivation: beyond 1 the damping is not observable",
)  # fmt: skip

# procedure
ANGLE_GAIN = _constant("ANGLE_GAIN", 2.0, "1/s", 0.0, 50.0,
    "Integral gain that turns the joint back to its angle at the start; both transmissions keep their deflections.",
    "engineering choice: above the frequencies of the slow sine, below those of motors and joint",
)  # fmt: skip
OVERLOAD = _constant("OVERLOAD", 1.05, "1", 1.0, 2.0,
    "Ratio to the limit of the force beyond which the run ends; up to it the range is narrowed.",
    "engineering choice: that of the stiffness controller",
)  # fmt: skip
FOLLOWING_ERROR = _constant("FOLLOWING_ERROR", 0.3, "rad", 0.001, 100.0,
    "Distance of a motor from its command beyond which it does not follow; half of the motion where that is less.",
    "engineering choice: that of the stiffness controller",
)  # fmt: skip
FOLLOWING_TIMEOUT_NS = _constant("FOLLOWING_TIMEOUT_NS", 1_000_000_000, "ns", 1_000_000, 10**11,
    "Duration of a following error before the run ends.",
    "engineering choice: a delay of the measurements on a busy machine is shorter",
)  # fmt: skip

# inputs
INVALID_TIMEOUT_NS = _constant("INVALID_TIMEOUT_NS", 3_000_000_000, "ns", 10_000_000, 10**11,
    "Duration of a flagged force or deflection after which the run ends; the reading of a noisy or late sensor still limits.",
    "engineering choice: three times the hold of a fault of the estimator",
)  # fmt: skip

# sample_rate and excitation_node
RATE_WINDOW_NS = _constant("RATE_WINDOW_NS", 500_000_000, "ns", 10_000_000, 10**10,
    "Time over which the rate of the samples is measured.",
    "derivation: 50 samples at 100 Hz",
)  # fmt: skip
START_TIMEOUT_NS = _constant("START_TIMEOUT_NS", 3_000_000_000, "ns", 100_000_000, 10**11,
    "Time after which a goal whose inputs are not present is refused.",
    "engineering choice: six windows of the rate of the samples",
)  # fmt: skip
YIELD_NS = _constant("YIELD_NS", 1_000_000_000, "ns", 10_000_000, 10**11,
    "Time since the last motor command of another node within which a goal is refused.",
    "derivation: the rate of a controller is 10 Hz or more",
)  # fmt: skip
OWN_COMMANDS = _constant("OWN_COMMANDS", 256, "1", 1, 100_000,
    "Commands whose echo is awaited, to distinguish them from those of another node.",
    "derivation: 0.25 s at the greatest rate of 1000 Hz, more than the delay of an echo",
)  # fmt: skip
FEEDBACK_PERIOD_NS = _constant("FEEDBACK_PERIOD_NS", 200_000_000, "ns", 10_000_000, 10**10,
    "Period of the feedback.",
    "engineering choice",
)  # fmt: skip
