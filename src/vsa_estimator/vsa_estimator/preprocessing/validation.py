# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Which samples enter the pipeline: finite, plausible magnitudes with increasing stamps."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_estimator.preprocessing.records import VALIDATION
from vsa_estimator.tuning.preprocessing import IMPLAUSIBLE_RATIO, MAX_LATE_RUN, MAX_LATENESS_NS

ACCEPT, DROP, TIME_RESET = range(3)


def initial_validation(force_limit: float, deflection_limit: float) -> NDArray[Any]:
    """(1,) VALIDATION before the first sample of sensors that saturate at these limits [N, m]."""
    state = np.zeros(1, VALIDATION)
    state["max_force"] = IMPLAUSIBLE_RATIO * force_limit
    state["max_deflection"] = IMPLAUSIBLE_RATIO * deflection_limit
    return state


@compiled
def validate(validation: Any, stamp_ns: int, force: float, deflection: float) -> int:
    """ACCEPT, DROP or TIME_RESET for a sample [ns, N, m]; `validation`: a VALIDATION record.

    After a TIME_RESET the same sample is accepted.
    """
    plausible = abs(force) < validation["max_force"] and abs(deflection) < validation["max_deflection"]
    if stamp_ns <= 0 or not plausible:  # NaN is not plausible
        return DROP
    last = validation["last_stamp_ns"]
    if stamp_ns > last:
        validation["last_stamp_ns"] = stamp_ns
        validation["late_run"] = 0
        return ACCEPT
    if stamp_ns < last:
        validation["late_run"] += 1
    if last - stamp_ns > MAX_LATENESS_NS or validation["late_run"] >= MAX_LATE_RUN:
        validation["last_stamp_ns"] = stamp_ns - 1
        validation["late_run"] = 0
        return TIME_RESET
    return DROP
