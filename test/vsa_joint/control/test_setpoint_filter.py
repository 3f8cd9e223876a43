# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The set-point filter against the analytic step response."""

import numpy as np
import pytest
from vsa_joint.control.setpoint_filter import SetpointFilter


def test_the_step_response_is_that_of_a_critically_damped_second_order_system():
    setpoint_filter = SetpointFilter(0.0)
    values = [setpoint_filter.step(1.0, 0.1, 0.01) for _ in range(200)]
    time = 0.01 * np.arange(1, 201)
    assert values == pytest.approx(1.0 - (1.0 + time / 0.1) * np.exp(-time / 0.1))
