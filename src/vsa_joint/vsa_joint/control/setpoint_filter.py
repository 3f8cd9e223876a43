# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Set-point filters: critically damped second order; rate limit and three equal lags."""

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


class RateLimitedFilter:
    """Value that follows a set-point through a limit of the rate and three equal lags.

    The limit bounds the speed, so that the lags need not grow with the step; the lags bound acceleration and jerk.
    """

    def __init__(self, value: float) -> None:
        self._limited = self._lagged = value
        self._filter = SetpointFilter(value)

    @property
    def value(self) -> float:
        """Present output."""
        return self._filter.value

    def step(self, setpoint: float, rate_max: float, time_constant: float, dt: float) -> float:
        """Value after `dt` [s]; `rate_max` in the value's unit per second, `time_constant` of each lag in s."""
        travel = rate_max * dt
        self._limited += min(max(setpoint - self._limited, -travel), travel)
        self._lagged += (self._limited - self._lagged) * (1.0 - math.exp(-dt / time_constant))
        return self._filter.step(self._lagged, time_constant, dt)

    def settle(self, time_constant: float, dt: float) -> None:
        """Value after `dt` [s] towards the limited set-point reached so far."""
        self.step(self._limited, 0.0, time_constant, dt)
