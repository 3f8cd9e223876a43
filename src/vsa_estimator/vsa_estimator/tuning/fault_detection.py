# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tuned constants of `vsa_estimator.fault_detection`."""

from functools import partial

from vsa_common.tuning import constant

_constant = partial(constant, module=__name__)

# Parity residual: measured force less the force of checkpointed coefficients on the motion of the encoder alone.
WINDOWS = _constant("WINDOWS", (0.12, 0.5, 3.0), "s", 0.05, 10.0,
    "averaging windows of the parity residual: fast faults of seconds, and slow drift", "ablation")  # fmt: skip
EVALUATION_PERIOD = _constant("EVALUATION_PERIOD", 0.05, "s", 0.02, 0.2,
    "interval of the parity evaluation: less than half of the shortest window, so that no residual is skipped", "ablation")  # fmt: skip
MAX_BASELINE = _constant("MAX_BASELINE", 0.1, "s", 0.05, 0.5,
    "longest baseline of the velocity difference", "docs/decisions/0016-parity-residual.md")  # fmt: skip
MIN_BASELINE = _constant("MIN_BASELINE", 0.03, "s", 0.02, 0.1,
    "shortest baseline: three filter steps at 100 Hz", "docs/decisions/0016-parity-residual.md")  # fmt: skip
VELOCITY_STD = _constant("VELOCITY_STD", 0.14e-3, "m/s", 0.05e-3, 0.5e-3,
    "noise of the velocity difference, that of 0.01 mm over 0.1 s: a quieter encoder allows a shorter baseline, whose error by jerk is smaller",
    "docs/decisions/0016-parity-residual.md")  # fmt: skip
MAX_DAMPER_ERROR = _constant("MAX_DAMPER_ERROR", 2.0, "N", 0.5, 8.0,
    "error of a residual by acceleration within the baseline, or as a single outlier, above which it is excluded", "ablation")  # fmt: skip
MEAN_SPEED_ERROR = _constant("MEAN_SPEED_ERROR", 1.0 / 3.0, "1", 0.1, 1.0,
    "error of the mean speed over a baseline, in its greatest deviation within it", "derivation: a constant jerk j over a baseline T makes it j T^2 / 24, and changes the acceleration a by at most 2 a, from -a to a; the deviation is a T / 4")  # fmt: skip
MOVING_SPEED = _constant("MOVING_SPEED", 0.2e-3, "m/s", 5e-5, 1e-3,
    "speed below which friction may take any value up to the Coulomb force", "ablation")  # fmt: skip
STICTION_RATIO = _constant("STICTION_RATIO", 1.3, "1", 0.5, 3.0,
    "breakaway force over Coulomb friction, subtracted from residuals at rest", "ablation")  # fmt: skip
MIN_COVERAGE = _constant("MIN_COVERAGE", 0.5, "1", 0.1, 1.0,
    "share of a window's forces that must be usable, and of its rows that move for the isolation of a shift", "ablation")  # fmt: skip
MIN_ROWS = _constant("MIN_ROWS", 5, "samples", 5, 20,
    "rows of the second difference over the baseline", "derivation: 2 half baselines and one centre row")  # fmt: skip

THRESHOLDS = _constant("THRESHOLDS", (5.5, 4.5, 4.0), "1", 2.0, 15.0,
    "threshold of the mean residual of each window, in its usual standard deviation: that of a short one has more of the error by jerk; the greatest in 2.7 h of healthy motion are 4.7, 3.2 and 2.7",
    "docs/decisions/0016-parity-residual.md")  # fmt: skip
CONSISTENT_SHARE = _constant("CONSISTENT_SHARE", 0.5, "1", 0.1, 1.0,
    "hysteresis: share of the threshold below which both sensors are consistent again", "ablation")  # fmt: skip
INITIAL_SCALE = _constant("INITIAL_SCALE", (0.3, 0.15, 0.1), "N", 0.02, 2.0,
    "prior of the usual mean residual of each window", "ablation")  # fmt: skip
PRIOR_WEIGHT = _constant("PRIOR_WEIGHT", 15, "evaluations", 2, 100,
    "weight of the prior of the residual scale", "ablation")  # fmt: skip
SCALE_CAP = _constant("SCALE_CAP", 4.0, "1", 1.5, 16.0,
    "cap of a squared mean in the residual scale, in units of the scale", "ablation")  # fmt: skip
MIN_SCALE = _constant("MIN_SCALE", 0.01, "N", 0.001, 0.1,
    "least residual scale: below it the force sensor's own steps decide", "derivation: mean of three forces with the noise of section VI, 0.017 N")  # fmt: skip
INSENSITIVE_RATIO = _constant("INSENSITIVE_RATIO", 3.0, "1", 1.0, 10.0,
    "standard deviation of the model force over the residual scale, above which the check is insensitive", "derivation: there the threshold is 1.5 times this standard deviation")  # fmt: skip
MAX_SCALE = _constant("MAX_SCALE", 0.4, "N", 0.1, 2.0,
    "residual scale above which the check is insensitive", "ablation")  # fmt: skip
EXTRAPOLATION_MARGIN = _constant("EXTRAPOLATION_MARGIN", 0.05, "1", 0.01, 0.5,
    "travel beyond the checkpoint's, in 1 / k2, up to which its elastic law holds", "ablation")  # fmt: skip

ISOLATION_TIME = _constant("ISOLATION_TIME", 2.5, "s", 0.5, 10.0,
    "time of inconsistency before a sensor shift is isolated", "test_a_force_offset_that_stays_is_taken_over_and_the_stiffness_kept")  # fmt: skip
MAX_RIPPLE = _constant("MAX_RIPPLE", 3.0, "1", 1.5, 6.0,
    "remaining ripple of the right hypothesis, in the usual standard deviation of a mean residual: 1.2 to 2.5 of a constant shift, 5 of a drift that is taken for one",
    "docs/decisions/0016-parity-residual.md")  # fmt: skip
LIKELIHOOD_MARGIN = _constant("LIKELIHOOD_MARGIN", 2.5, "1", 1.2, 10.0,
    "ratio of the remaining ripple between the hypotheses of a force and of an encoder shift", "ablation")  # fmt: skip

CHECKPOINT_PERIOD = _constant("CHECKPOINT_PERIOD", 4.0, "s", 1.0, 20.0,
    "interval of checkpoints: a fault is compared with coefficients 4 to 8 s old", "test_a_drifting_force_is_detected_before_the_stiffness_is_wrong")  # fmt: skip
MIN_TRACKING_TIME = _constant("MIN_TRACKING_TIME", 7.0, "s", 2.0, 30.0,
    "consistent tracking before a checkpoint outweighs the present sensors", "ablation")  # fmt: skip
FAULT_TIMEOUT = _constant("FAULT_TIMEOUT", 6.0, "s", 2.0, 30.0,
    "time of unexplained inconsistency before the coefficients are rejected", "ablation")  # fmt: skip

# Isolation of an encoder step among rejected deflections.
ONSET_GROWTH = _constant("ONSET_GROWTH", 1.2, "1", 1.05, 2.4,
    "growth between successive offsets, three in a row, that shows an onset of motion", "docs/decisions/0003-onset-of-motion.md, test_growing_offsets_are_an_onset_of_motion")  # fmt: skip
REPEAT_SHARE = _constant("REPEAT_SHARE", 0.5, "1", 0.2, 1.0,
    "share of the rejected offset above which a deflection repeats it", "ablation")  # fmt: skip
MIN_COUNT = _constant("MIN_COUNT", 6, "samples", 3, 20,
    "rejected offsets that confirm a step: a noisy or stuck encoder gives fewer alike", "docs/decisions/0008-encoder-step.md, test_six_offsets_alike_confirm_a_step")  # fmt: skip
MAX_SCATTER = _constant("MAX_SCATTER", 0.25, "1", 0.05, 1.0,
    "standard deviation of the offsets over the step", "test_offsets_that_scatter_by_a_quarter_of_the_step_are_not_confirmed")  # fmt: skip
DISCONTINUITY_SHARE = _constant("DISCONTINUITY_SHARE", 0.5, "1", 0.1, 1.0,
    "share of an encoder step that is within one change between samples; the offset's size is uncertain by the prediction", "test_a_motion_is_spread_over_samples_and_a_step_is_within_one")  # fmt: skip
FORCE_SUPPORT_SHARE = _constant("FORCE_SUPPORT_SHARE", 0.5, "1", 0.1, 1.0,
    "share of the elastic force of a motion below which the force supports the expected position", "test_the_force_supports_the_expected_position_unless_it_has_changed_by_half_of_the_elastic_force")  # fmt: skip

FAULT_HOLD_TIME = _constant("FAULT_HOLD_TIME", 0.5, "s", 0.1, 5.0,
    "an active fault is reported for this long after its last detection", "reporting: two periods of a viewer at 4 Hz")  # fmt: skip
