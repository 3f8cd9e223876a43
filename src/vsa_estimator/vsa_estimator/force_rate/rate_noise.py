# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Noise of the filtered force rate: sensor noise, and the disturbance by Coulomb friction at reversals.

Coulomb friction is part of the force rate, other than section V assumes: each reversal is a step of 2 d0 in the force,
an impulse of 2 d0 / tau in the filtered rate.
"""

import math

from vsa_estimator.tuning.force_rate import MAX_REVERSAL_STDS, RATE_FILTER, REVERSAL_SPEED


class RateNoise:
    """Standard deviation of the filtered force rate after the last reversal."""

    def __init__(self, force_noise_std: float) -> None:
        """`force_noise_std` of one sample [N]."""
        self._white_std = force_noise_std / RATE_FILTER  # [N/s]
        self._reversed_ns = 0
        self._direction = 0.0

    def update(self, stamp_ns: int, speed: float) -> None:
        """Detect a reversal by the `speed` [m/s] at `stamp_ns`."""
        direction = math.copysign(1.0, speed)
        if abs(speed) < REVERSAL_SPEED or direction != self._direction:
            self._reversed_ns, self._direction = stamp_ns, direction

    def std(self, stamp_ns: int, samples: int, friction: float) -> float:
        """Standard deviation [N/s] of the mean of `samples` at `stamp_ns`, with Coulomb `friction` [N]."""
        age = (stamp_ns - self._reversed_ns) * 1e-9
        disturbance = 2.0 * friction / RATE_FILTER * math.exp(-age / RATE_FILTER)
        return math.hypot(self._white_std / math.sqrt(samples), disturbance)

    def is_friction_dominant(self, friction: float) -> bool:
        """Whether the disturbance at a reversal is so large that it degrades the estimate."""
        return 2.0 * friction / RATE_FILTER > MAX_REVERSAL_STDS * self._white_std
