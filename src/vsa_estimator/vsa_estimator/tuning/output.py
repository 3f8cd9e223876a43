# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tuned constants of `vsa_estimator.output`: validity, silence, prediction."""

from functools import partial

from vsa_common.tuning import constant

_constant = partial(constant, module=__name__)

# Validity: greatest standard deviations, relative to the quantity unless a unit is given.
MAX_STIFFNESS_STD = _constant("MAX_STIFFNESS_STD", 0.1, "1", 0.01, 0.5,
    "stiffness", "requirement: 10 % is what a stiffness controller tolerates")  # fmt: skip
MAX_SEPARATION_STD = _constant("MAX_SEPARATION_STD", 0.25, "1", 0.05, 1.0,
    "d1, for a valid stiffness before hand-over: else spring and damper are not separated", "docs/decisions/0002-hand-over-and-cross-check.md")  # fmt: skip
MAX_DAMPING_STD = _constant("MAX_DAMPING_STD", 0.15, "1", 0.01, 0.5,
    "damping and d1", "requirement")  # fmt: skip
MIN_DAMPING_SCALE = _constant("MIN_DAMPING_SCALE", 0.2, "1", 0.05, 1.0,
    "share of d1 that the damping is compared with where it vanishes", "derivation: D = 0.2 d1 at 0.9 v*")  # fmt: skip
MAX_SPEED_SHARE = _constant("MAX_SPEED_SHARE", 0.9, "1", 0.45, 1.0,
    "share of v* up to which damping is valid: beyond v* it is not observable", "ablation")  # fmt: skip
MAX_K2_STD = _constant("MAX_K2_STD", 0.05, "1", 0.01, 0.5, "k2", "requirement")  # fmt: skip
MAX_D2_STD = _constant("MAX_D2_STD", 0.25, "1", 0.05, 1.0, "d2", "requirement")  # fmt: skip
MAX_INERTIA_STD = _constant("MAX_INERTIA_STD", 0.2, "1", 0.05, 1.0, "inertia", "requirement")  # fmt: skip
MIN_INERTIAL_FORCE = _constant("MIN_INERTIAL_FORCE", 3.0, "1", 1.0, 10.0,
    "inertial force over force noise of a valid inertia", "test_inertia_of_a_light_mass_at_slow_speed_is_never_valid_and_the_needed_motion_is_named")  # fmt: skip
MAX_FORCE_OFFSET_STD = _constant("MAX_FORCE_OFFSET_STD", 1.0, "N", 0.1, 10.0, "F0", "requirement")  # fmt: skip
MAX_FRICTION_STD = _constant("MAX_FRICTION_STD", 0.2, "N", 0.02, 2.0, "d0", "requirement")  # fmt: skip

POSITION_GATE = _constant("POSITION_GATE", 16.0, "1", 4.0, 64.0,
    "NIS of a raw deflection; two successive ones above it widen position and stiffness by the square of the second", "ablation")  # fmt: skip
MAX_PREDICTION_TIME = _constant("MAX_PREDICTION_TIME", 0.25, "s", 0.05, 2.0,
    "longest prediction; a longer gap resets position and motion", "ablation")  # fmt: skip
STALE_PERIODS = _constant("STALE_PERIODS", 5, "periods", 2, 20, "silence of STALE, or STALE_TIME if that is longer", "contract: docs/reference/faults.md")  # fmt: skip
STALE_TIME = _constant("STALE_TIME", 0.05, "s", 0.01, 0.5, "silence of STALE", "contract: docs/reference/faults.md")  # fmt: skip
INVALID_TIME = _constant("INVALID_TIME", 0.1, "s", 0.05, 1.0, "silence that invalidates", "contract: docs/reference/faults.md")  # fmt: skip
STATED_ERROR = _constant("STATED_ERROR", 1.96, "1", 1.0, 4.0,
    "error of the model force that is stated, in its standard deviation: no misfit", "derivation: 95 % interval")  # fmt: skip
ADEQUACY_MEMORY = _constant("ADEQUACY_MEMORY", 40.0, "windows in motion", 10.0, 160.0,
    "memory of the unexplained force: that of the usual residual, 20 s", "EXCITATION_TIME_CONSTANT")  # fmt: skip
DEFLECTION_BIN = _constant("DEFLECTION_BIN", 0.25, "1", 0.05, 1.0,
    "width of the bins of the residual by deflection, in 1 / k2", "reported only: 1 mm of the paper's springs")  # fmt: skip
VELOCITY_BIN = _constant("VELOCITY_BIN", 0.25, "1", 0.05, 1.0,
    "width of the bins of the residual by velocity, in v*", "reported only: the cubic term changes the damping by at most half in it")  # fmt: skip
LOCATION_VISITS = _constant("LOCATION_VISITS", 40.0, "1", 10.0, 400.0,
    "memory of the mean residual of a bin, in visits", "reported only")  # fmt: skip
LOCATION_SIGNIFICANCE = _constant("LOCATION_SIGNIFICANCE", 4.0, "1", 2.0, 10.0,
    "mean residual of a bin that is reported, in its standard error", "derivation: 64 bins, one of 250 normal means of them all exceeds it")  # fmt: skip
MAX_BEYOND_PEAK = _constant(
    "MAX_BEYOND_PEAK", 0.1, "1", 0.01, 0.5,
    "probability of a speed near or beyond v* above which damping is not observable", "a tenth of the mixture",
)  # fmt: skip
