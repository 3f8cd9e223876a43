# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Single outliers of a stream that is sampled much faster than it moves."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_estimator.preprocessing.records import OUTLIER
from vsa_estimator.tuning.preprocessing import MAX_OUTLIER_RUN, OUTLIER_GATE, OUTLIER_WINDOW, VIBRATION_GATE


def initial_outlier(std: float) -> NDArray[Any]:
    """(1,) OUTLIER before the first sample; `std` of the white noise."""
    state = np.zeros(1, OUTLIER)
    state["gate"] = OUTLIER_GATE * math.sqrt(6.0) * std  # a second difference has 6 times the variance
    state["last"] = state["before_last"] = math.nan
    return state


@compiled
def accept(outlier: Any, value: float) -> bool:
    """Whether a sample continues the line through its two predecessors; `outlier`: an OUTLIER record.

    A vibration is no outlier: its second differences are at most a few times their mean magnitude.
    """
    run, difference = outlier["run"], abs(value - 2.0 * outlier["last"] + outlier["before_last"])
    gate = max(outlier["gate"], VIBRATION_GATE * outlier["level"])
    if run < MAX_OUTLIER_RUN and difference > gate:
        outlier["run"] = run + 1
        return False
    if not np.isnan(difference):
        outlier["level"] += (min(difference, gate) - outlier["level"]) / OUTLIER_WINDOW
    outlier["before_last"] = value if run > 0 or np.isnan(outlier["last"]) else outlier["last"]
    outlier["last"] = value
    outlier["run"] = 0
    return True
