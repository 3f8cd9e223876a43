# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Records of stiffness control: command, measurement, feasibility, and the newest inputs with their instants."""

import math
from dataclasses import dataclass, field

from vsa_joint.control.springs import Spring, Springs
from vsa_joint.control.stiffness_range import StiffnessRange


@dataclass(frozen=True)
class Target:
    """Set-points: unloaded equilibrium angle [rad] and stiffness [N m/rad]."""

    equilibrium: float
    stiffness: float


@dataclass(frozen=True)
class Measurement:
    """State of the joint in one control period, from valid measurements and the last valid estimates."""

    angle: float  # rad
    tension: tuple[float, float]  # N
    stiffness: float  # N m/rad
    damping: float  # N m s/rad
    motors: tuple[float, float]  # rad
    springs: Springs
    force_valid: bool = True  # of both tensions


@dataclass(frozen=True)
class Feasibility:
    """Result of the check of a command; `text` is the reason of a refusal or a warning."""

    accepted: bool
    text: str
    reachable: StiffnessRange | None
    predicted_error: float  # relative, of the stiffness


@dataclass(frozen=True)
class Fault:
    """Why control is not possible, and what it waits for."""

    text: str
    waits_for: str


@dataclass(frozen=True)
class JointMeasurement:
    """Fields of a JointImpedance that the controller uses (SI)."""

    stiffness: float
    stiffness_valid: bool
    damping: float
    damping_valid: bool
    tension: tuple[float, float]
    force_valid: bool
    status: int
    reason: str


@dataclass
class Inputs:
    """The newest of each input with the instant of its arrival [ns] on the steady clock.

    `measured_ns` has the instants of the stamps by topic, so that delayed messages do not count as current.
    """

    joint: JointMeasurement | None = None
    joint_ns: int = 0
    angle: float = math.nan  # rad
    angle_ns: int = 0
    motors: tuple[float, float] | None = None  # rad
    motors_ns: int = 0
    springs: tuple[Spring | None, Spring | None] = (None, None)
    springs_ns: tuple[int, int] = (0, 0)
    estimator_faults: tuple[str, str] = ("", "")
    sensor_faults: tuple[bool, bool] = (False, False)  # whether an estimator has detected one
    measured_ns: dict[str, int] = field(default_factory=dict)
