# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Single outliers of a stream that is sampled much faster than it moves."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_estimator.preprocessing.records import OUTLIER
from vsa_estimator.tuning.preprocessing import MAX_OUTLIER_RUN, OUTLIER_GATE


def initial_outlier(std: float) -> NDArray[Any]:
    """(1,) OUTLIER before the first sample; `std` of the white noise."""
    state = np.zeros(1, OUTLIER)
    state["gate"] = OUTLIER_GATE * math.sqrt(6.0) * std  # a second difference has 6 times the variance
    state["last"] = state["before_last"] = math.nan
    return state


@compiled
def accept(outlier: Any, value: float, vibration: float) -> bool:
    """Whether a sample continues the line through its two predecessors; `outlier`: an OUTLIER record.

    `vibration` bounds the amplitude of a vibration, whose second difference is at most four times as large.
    """
    run, gate = outlier["run"], outlier["gate"] + 4.0 * vibration
    if run < MAX_OUTLIER_RUN and abs(value - 2.0 * outlier["last"] + outlier["before_last"]) > gate:
        outlier["run"] = run + 1
        return False
    outlier["before_last"] = value if run > 0 or np.isnan(outlier["last"]) else outlier["last"]
    outlier["last"] = value
    outlier["run"] = 0
    return True
