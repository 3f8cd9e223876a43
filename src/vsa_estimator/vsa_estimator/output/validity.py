# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Validity of the coefficients, and the motion that an invalid quantity needs."""

from typing import NamedTuple

import numpy as np
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.force_law.damper import peak_speed
from vsa_estimator.force_law.state import Z
from vsa_estimator.tuning.filter import MIN_STROKE
from vsa_estimator.tuning.output import (
    MAX_D2_STD,
    MAX_DAMPING_STD,
    MAX_FORCE_OFFSET_STD,
    MAX_FRICTION_STD,
    MAX_INERTIA_STD,
    MAX_K2_STD,
    MAX_SPEED_SHARE,
    MAX_STIFFNESS_STD,
    MIN_INERTIAL_FORCE,
)


class Observability(NamedTuple):
    """Validity of each coefficient."""

    stiffness: bool
    k2: bool
    d1: bool
    d2: bool
    inertia: bool
    force_offset: bool
    coulomb_friction: bool


UNOBSERVABLE = Observability(*[False] * len(Observability._fields))


def assess_observability(tracker: Tracker, force_noise_std: float) -> Observability:
    """Validity of the coefficients at the last step; `force_noise_std` [N] of one sample."""
    std = np.sqrt(np.maximum(np.diag(tracker.p), 0.0)).tolist()
    k2, d1, d2 = (abs(float(tracker.z[index])) for index in (Z.K2, Z.D1, Z.D2))
    return Observability(
        stiffness=std[Z.S] < MAX_STIFFNESS_STD,
        k2=tracker.uncertainty.k2_variance < (MAX_K2_STD * k2) ** 2 and tracker.sufficient_stroke,
        d1=std[Z.D1] < MAX_DAMPING_STD * d1,
        d2=tracker.uncertainty.d2_variance < (MAX_D2_STD * d2) ** 2,
        inertia=inertia_observable(tracker, force_noise_std),
        force_offset=std[Z.F0] < MAX_FORCE_OFFSET_STD,
        coulomb_friction=std[Z.D0] < MAX_FRICTION_STD,
    )


def inertia_observable(tracker: Tracker, force_noise_std: float) -> bool:
    """Whether the motion makes the mass observable."""
    now = tracker.uncertainty
    tolerance = MAX_INERTIA_STD * float(tracker.z[Z.M])
    return now.inertia_variance < tolerance * tolerance and now.inertial_force > MIN_INERTIAL_FORCE * force_noise_std


def describe_unobservable(
    tracker: Tracker, observable: Observability, stiffness_valid: bool, damping_valid: bool
) -> tuple[str, ...]:
    """One line for each quantity that is not valid: which, why, what motion it needs."""
    lines = []
    if not stiffness_valid:
        lines.append("stiffness: standard deviation above 10 %; move slowly over several millimetres")
    if not observable.k2:
        if tracker.sufficient_stroke:
            lines.append("k2: standard deviation above 5 %; keep moving")
        else:
            needed = 1e3 * MIN_STROKE / max(float(tracker.z[Z.K2]), 1.0)
            lines.append(f"k2: not observable on {1e3 * tracker.stroke:.1f} mm of travel; move over {needed:.1f} mm")
    if not damping_valid:
        limit = MAX_SPEED_SHARE * peak_speed(float(tracker.z[Z.D1]), float(tracker.z[Z.D2]))
        if abs(tracker.speed) >= limit:
            lines.append(f"damping: not observable beyond {1e3 * limit:.1f} mm/s, the damper's maximum; move slower")
        else:
            lines.append("damping: standard deviation above 15 %; move at different speeds up to a few mm/s")
    if not observable.d2:
        lines.append("d2: not observable at this speed; move faster than half the damper's maximum")
    if not observable.inertia:
        lines.append("inertia: not observable at this excitation; move with two tones above 0.7 Hz")
    if not observable.force_offset:
        lines.append("force_offset: standard deviation above 1 N; move over several millimetres")
    if not observable.coulomb_friction:
        lines.append("coulomb_friction: standard deviation above 0.2 N; reverse the motion")
    return tuple(lines)
