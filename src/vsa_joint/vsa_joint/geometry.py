# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Geometry between both transmissions and the joint, with its uncertainty."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class TendonPath:
    """Tendon of one transmission: capstan radius [m] and tendon stiffness [N/m]."""

    radius: float
    tendon_stiffness: float


@dataclass(frozen=True, slots=True)
class TendonPathStd:
    """Standard deviations of the capstan radius [m] and the tendon stiffness [N/m] of one transmission."""

    radius: float = 0.0
    tendon_stiffness: float = 0.0


@dataclass(frozen=True, slots=True)
class Joint:
    """Tendon paths of transmission_1 and transmission_2; the joint's own damping [N m s/rad] and inertia [kg m^2]."""

    paths: tuple[TendonPath, TendonPath]
    damping: float = 0.0
    inertia: float = 0.0
