# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Critically damped second-order set-point filter."""

import math


class SetpointFilter:
    """Value that follows a set-point with critical damping."""

    def __init__(self, value: float) -> None:
        self.value = value
        self._rate = 0.0

    def step(self, setpoint: float, time_constant: float, dt: float) -> float:
        """Value after `dt`, the exact solution for a constant set-point; `time_constant` and `dt` in s."""
        error = self.value - setpoint
        slope = self._rate + error / time_constant
        decay = math.exp(-dt / time_constant)
        self.value = setpoint + (error + slope * dt) * decay
        self._rate = (self._rate - slope * dt / time_constant) * decay
        return self.value
