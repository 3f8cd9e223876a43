# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tuned constants of `vsa_estimator.supervisor`."""

from functools import partial

from vsa_common.tuning import constant

_constant = partial(constant, module=__name__)

REFRESH_PERIOD = _constant("REFRESH_PERIOD", 0.5, "s", 0.1, 2.0,
    "interval at which noise levels, jerk density and start values are renewed", "ablation")  # fmt: skip
NOISE_MEMORY = _constant("NOISE_MEMORY", 9.0, "s", 2.0, 60.0,
    "memory of the noise levels", "ablation")  # fmt: skip
COUNTED_GAP = _constant("COUNTED_GAP", 1.0, "s", 0.25, 10.0,
    "silence that counts as a reset", "contract: docs/reference/faults.md")  # fmt: skip
PAUSE_PERIODS = _constant("PAUSE_PERIODS", 2.5, "periods", 1.0, 10.0,
    "pause, in periods of filter or samples, after which an outlier is a discontinuity of the motion", "docs/decisions/0008-encoder-step.md")  # fmt: skip
TIMING_SUSPECT_NS = _constant("TIMING_SUSPECT_NS", 100_000_000, "ns", 10_000_000, 1_000_000_000,
    "time after a burst or an encoder fault in which an outlier is a discontinuity of the motion", "docs/decisions/0008-encoder-step.md")  # fmt: skip
MOTION_HOLD_TIME = _constant("MOTION_HOLD_TIME", 1.0, "s", 0.1, 10.0,
    "data is kept for initialization until this long after the motion ends", "ablation")  # fmt: skip
POSITION_RESET_TIMEOUT = _constant("POSITION_RESET_TIMEOUT", 0.2, "s", 0.05, 2.0,
    "time of rejected deflections after which the position is reset", "ablation")  # fmt: skip
MANOEUVRE_RATIO = _constant("MANOEUVRE_RATIO", 30.0, "1", 3.0, 300.0,
    "ratio of jerk densities within one step that restarts the innovation covariance matching", "ablation")  # fmt: skip
INERTIA_NEGLIGIBLE = _constant("INERTIA_NEGLIGIBLE", 0.3, "1", 0.05, 2.0,
    "inertial force over force noise below which the mass is not observable and the jerk floor is the lower one", "docs/decisions/0004-jerk-density.md")  # fmt: skip
