# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Flags that preprocessing raises on a raw sample; one bit field."""

from enum import IntFlag


class SensorFlag(IntFlag):
    """Findings of the sensor checks and of the outlier filters."""

    FORCE_REPEATED = 1  # same value as the sample before
    FORCE_STUCK = 2  # constant during motion
    ENCODER_CONSTANT = 4  # stationary or stuck
    ENCODER_STUCK = 8  # constant during a change of force
    ENCODER_FROZEN = 16  # dither of the last digit has ceased
    FORCE_NOISY = 32
    ENCODER_NOISY = 64
    BURST = 128  # samples were queued in transmission
    FORCE_SATURATED = 256
    DEFLECTION_SATURATED = 512
    ENCODER_NOISE_SEVERE = 1024
    ENCODER_FAULT = 2048  # the encoder is unusable
    FORCE_OUTLIER = 4096
    DEFLECTION_OUTLIER = 8192
    TIMING_SUSPECT = 16384  # samples arrive together: the clock may have stood still


ENCODER_FAULT_MASK = int(
    SensorFlag.ENCODER_FROZEN
    | SensorFlag.ENCODER_STUCK
    | SensorFlag.DEFLECTION_SATURATED
    | SensorFlag.ENCODER_NOISE_SEVERE
    | SensorFlag.BURST
)

# A constant force carries no information, and a stationary or stuck encoder biases the coefficients.
EXCLUDE_FROM_UPDATE = int(
    SensorFlag.FORCE_REPEATED
    | SensorFlag.ENCODER_CONSTANT
    | SensorFlag.FORCE_SATURATED
    | SensorFlag.DEFLECTION_SATURATED
)
