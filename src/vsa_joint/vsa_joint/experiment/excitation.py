# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""External torque for the identification of the joint: a multisine with low crest factor.

It is periodic, so that averages over whole periods have no leakage.
"""

from dataclasses import dataclass

import numpy as np
from vsa_common.types import Array
from vsa_joint.geometry import Joint
from vsa_joint.impedance.reflection import Transmissions, response
from vsa_joint.tuning import ANGLE_MAX, SPEED_SHARE

PERIOD = 20.0  # s
FRICTION_LINES = (1, 2, 3, 5, 8, 13)  # slow: the spring dominates the friction
RESPONSE_LINES = (
    1,
    3,
    5,
    9,
    15,
    25,
    41,
    69,
    115,
    191,
    319,
    399,
)  # odd: even distortion of the spring falls between them


@dataclass(frozen=True)
class Multisine:
    """Sum of cosines of equal amplitude at `lines` / `period`; `phases` in rad, `amplitude` in N m."""

    lines: tuple[int, ...]
    phases: tuple[float, ...]
    amplitude: float
    period: float = PERIOD

    def __call__(self, time: Array) -> Array:
        """Torque at each instant [N m]."""
        turns = np.outer(time, np.array(self.lines) / self.period)
        return self.amplitude * np.cos(2.0 * np.pi * turns + np.array(self.phases)).sum(axis=1)

    @property
    def rms(self) -> float:
        """Root mean square [N m]."""
        return self.amplitude * float(np.sqrt(len(self.lines) / 2.0))

    @property
    def frequency(self) -> Array:
        """Frequency of each line [Hz]."""
        return np.array(self.lines) / self.period


def low_crest_phases(lines: tuple[int, ...], seed: int, tries: int = 300) -> tuple[float, ...]:
    """Phases [rad] with the lowest peak of `tries` random sets."""
    generator = np.random.default_rng(seed)
    phases = generator.uniform(0.0, 2.0 * np.pi, (tries, len(lines)))
    points = 4 * max(lines)
    spectrum = np.zeros((tries, points // 2 + 1), dtype=complex)
    spectrum[:, list(lines)] = np.exp(1j * phases)
    peaks = np.abs(np.fft.irfft(spectrum, points, axis=1)).max(axis=1)
    return tuple(float(phase) for phase in phases[int(np.argmin(peaks))])


def multisine(lines: tuple[int, ...], rms: float, seed: int) -> Multisine:
    """Multisine of equal amplitudes with a given rms [N m]."""
    return Multisine(lines, low_crest_phases(lines, seed), rms * float(np.sqrt(2.0 / len(lines))))


def largest_multisine(
    lines: tuple[int, ...], seed: int, transmissions: Transmissions, joint: Joint, damper_speed: float
) -> Multisine:
    """Largest multisine whose predicted response is within ANGLE_MAX and the peak speed of the dampers.

    `damper_speed` is the deflection rate of the greatest damper force [m/s], the smaller of both transmissions.
    """
    unit = multisine(lines, 1.0, seed)
    per_torque = 1.0 / response(unit.frequency, transmissions, joint)
    time = np.arange(0.0, unit.period, unit.period / (40 * max(lines)))
    wave = np.exp(1j * (2.0 * np.pi * np.outer(time, unit.frequency) + np.array(unit.phases)))
    angle = unit.amplitude * (wave * per_torque).real.sum(axis=1)
    speed = unit.amplitude * (wave * per_torque * 2j * np.pi * unit.frequency).real.sum(axis=1)
    radius = max(path.radius for path in joint.paths)
    by_angle = ANGLE_MAX / float(np.abs(angle).max())
    by_speed = SPEED_SHARE * damper_speed / (0.5 * radius * float(np.abs(speed).max()))
    return multisine(lines, min(by_angle, by_speed), seed)
