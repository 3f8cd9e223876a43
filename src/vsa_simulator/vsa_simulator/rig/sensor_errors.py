# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Systematic errors of the sensors: true forces and deflections to those that noise and resolution act on.

Chain of the force: crosstalk, hysteresis, low-pass, delay, drift of zero. What has memory runs at `RATE_HZ` or more,
whatever the rate of the samples, and starts in its steady state.
"""

import math
from typing import NamedTuple

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_simulator.rig.config import SensorErrorConfig

RATE_HZ = 4000.0  # of truth for errors with memory: interpolation between rows is exact within 1e-4 N at 10 Hz

NO_ERRORS = SensorErrorConfig()

_INPUT, _HYSTERESIS, _UNFILTERED, _FILTERED, _AGES = range(5)  # state of one force; ages: delayed values, newest first


class _ForceError(NamedTuple):
    """Parameters for compiled code, SI."""

    hysteresis: float
    span: float
    decay: float  # of the low-pass within one row
    mean_age: float  # of a linear input within one row, as the low-pass weighs it
    filtered: bool
    delay: float  # [rows]


def oversampling(errors: SensorErrorConfig, rate_hz: float) -> int:
    """Rows of truth a sample that the errors require; 1 without errors that have memory."""
    memory = errors.force_delay > 0.0 or errors.force_lowpass > 0.0 or errors.force_hysteresis > 0.0
    return math.ceil(RATE_HZ / rate_hz) if memory else 1


def encoder_error(deflection: Array, errors: SensorErrorConfig) -> Array:
    """Error of the encoder [m]: a sin(2 pi x / pitch), as of interpolation within the periods of its scale."""
    if errors.encoder_cyclic == 0.0:
        return np.zeros_like(deflection)
    return errors.encoder_cyclic * np.sin(2.0 * np.pi * deflection / errors.encoder_pitch)


class ForceErrors:
    """Errors of `channels` force sensors over rows at `rate_hz` [Hz]; blocks of any size give the same sequence."""

    def __init__(self, errors: SensorErrorConfig, rate_hz: float, channels: int = 2) -> None:
        self._config, self._rate = errors, rate_hz
        lag = 1.0 / (2.0 * math.pi * errors.force_lowpass) if errors.force_lowpass > 0.0 else 0.0
        decay = math.exp(-1.0 / (rate_hz * lag)) if lag else 0.0
        self._error = _ForceError(
            errors.force_hysteresis,
            errors.force_hysteresis_span,
            decay,
            lag * rate_hz * (1.0 - decay),
            lag > 0.0,
            errors.force_delay * rate_hz,
        )
        self._states = np.zeros((channels, _AGES + 2 + math.ceil(self._error.delay)))
        self._rows = 0

    def apply(self, forces: Array, others: Array) -> Array:
        """Forces with errors [N], a row an instant, a column a sensor; `others` act on them by crosstalk."""
        affected = forces + self._config.crosstalk * others
        if not self._rows:
            self._start(affected[0])
        for channel, state in zip(affected.T, self._states, strict=True):
            _distort(channel, self._error, state)
        time = (self._rows + np.arange(len(forces))) / self._rate
        self._rows += len(forces)
        return affected + self._config.force_drift / 60.0 * time[:, None]

    def _start(self, forces: Array) -> None:
        self._states[:] = forces[:, None]
        self._states[:, _HYSTERESIS] = 0.0


@compiled
def _distort(force: Array, p: _ForceError, state: Array) -> None:
    """Replace a force by that after hysteresis, low-pass and delay, row by row."""
    whole = int(p.delay)
    part = p.delay - whole
    for row in range(force.shape[0]):
        change = force[row] - state[_INPUT]
        state[_INPUT] = force[row]
        value = force[row]
        if p.hysteresis > 0.0:
            sign = math.copysign(1.0, change)  # Dahl's model, exact within a row
            state[_HYSTERESIS] = sign + (state[_HYSTERESIS] - sign) * math.exp(-abs(change) / p.span)
            value += p.hysteresis * state[_HYSTERESIS]
        if p.filtered:  # exact for an input that is linear within a row
            step = value - state[_UNFILTERED]
            state[_FILTERED] = value - p.mean_age * step + p.decay * (state[_FILTERED] - state[_UNFILTERED])
            state[_UNFILTERED] = value
            value = state[_FILTERED]
        if p.delay > 0.0:
            for age in range(whole + 1, 0, -1):
                state[_AGES + age] = state[_AGES + age - 1]
            state[_AGES] = value
            value = (1.0 - part) * state[_AGES + whole] + part * state[_AGES + whole + 1]
        force[row] = value
