# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Forces with memory, which act beside the static elastic law: viscoelastic branch and hysteresis."""

from dataclasses import dataclass

from vsa_common.accel import compiled
from vsa_common.config.configuration import quantity


@dataclass(frozen=True)
class ViscoelasticConfig:
    """Maxwell branch of both transmissions, parallel to the spring."""

    share: float = quantity(0.0, "", 0.0, 2.0, "stiffness of the branch over that of the spring; 0: none")
    time_constant: float = quantity(2.0, "s", 0.01, 1000.0, "time in which its force relaxes to 37 %")


@dataclass(frozen=True)
class HysteresisConfig:
    """Bouc-Wen hysteresis of both transmissions, parallel to the spring."""

    amplitude: float = quantity(0.0, "N", 0.0, 50.0, "greatest hysteretic force; 0: none")
    travel: float = quantity(4e-4, "m", 1e-6, 0.1, "amplitude over initial slope: travel scale of a reversal")
    shape: float = quantity(0.5, "", 0.0, 0.5, "0: Dahl's model; 0.5: elastic unloading; above, energy could appear")


@compiled
def branch_rate(q: float, v: float, stiffness: float, share: float, time_constant: float) -> float:
    """dq/dt = share sigma v - q / T: rate of the Maxwell branch's force `q` [N/s] (Maxwell 1867)."""
    return share * stiffness * v - q / time_constant


@compiled
def hysteresis_rate(y: float, v: float, travel: float, shape: float) -> float:
    """dy/dt = v / delta (1 - c |y| - (1 - c) sgn(v) y): hysteretic force over its amplitude, |y| <= 1 [1/s].

    Bouc 1967, Wen 1976 with exponent 1; c <= 0.5 dissipates in every motion (Erlicher and Point 2004).
    """
    return (v - shape * abs(y) * v - (1.0 - shape) * abs(v) * y) / travel
