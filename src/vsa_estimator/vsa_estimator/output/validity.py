"""Which quantities are known, and what motion would help where one is not."""

from typing import NamedTuple

import numpy as np
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.force_law.damper import peak_speed
from vsa_estimator.force_law.state import Z
from vsa_estimator.output.predictor import DAMPING, NEAR_MAXIMUM, STIFFNESS
from vsa_estimator.tuning.filter import MIN_STROKE

K2 = 0.05
CUBIC = 0.25  # of a valid d2
INERTIA = 0.2
CLEAR_FORCE = 3.0  # standard deviations of the force noise that it takes to move a valid inertia


class Observability(NamedTuple):
    """Validity of each coefficient; the words for those that are not."""

    stiffness: bool
    k2: bool
    d1: bool
    d2: bool
    inertia: bool
    force_offset: bool
    coulomb_friction: bool


def assess_observability(tracker: Tracker, force_noise_std: float) -> Observability:
    """What the filter knows at its last step; `force_noise_std` [N] of one sample."""
    z, p = tracker.z, tracker.p
    std = np.sqrt(np.maximum(np.diag(p), 0.0)).tolist()
    k2, d1, d2 = (abs(value) for value in z[4:7].tolist())
    return Observability(
        stiffness=std[Z.S] < STIFFNESS,
        k2=tracker.uncertainty.k2_variance < (K2 * k2) ** 2 and tracker.sufficient_stroke,
        d1=std[Z.D1] < DAMPING * d1,
        d2=tracker.uncertainty.d2_variance < (CUBIC * d2) ** 2,
        inertia=inertia_observable(tracker, force_noise_std),
        force_offset=std[Z.F0] < 1.0,
        coulomb_friction=std[Z.D0] < 0.2,
    )


def inertia_observable(tracker: Tracker, force_noise_std: float) -> bool:
    """Whether the motion has told the mass."""
    now = tracker.uncertainty
    tolerance = INERTIA * float(tracker.z[Z.M])
    return now.inertia_variance < tolerance * tolerance and now.inertial_force > CLEAR_FORCE * force_noise_std


def describe_unobservable(
    tracker: Tracker, known: Observability, stiffness_valid: bool, damping_valid: bool
) -> tuple[str, ...]:
    """One line for each quantity that is not valid: which, why, what motion helps."""
    lines = []
    if not stiffness_valid:
        lines.append("stiffness: not yet known within 10 %; move slowly over several millimetres")
    if not known.k2:
        if tracker.sufficient_stroke:
            lines.append("k2: not yet known within 5 %; keep moving")
        else:
            needed = 1e3 * MIN_STROKE / max(float(tracker.z[Z.K2]), 1.0)
            lines.append(f"k2: not observable on {1e3 * tracker.stroke:.1f} mm of travel; move over {needed:.1f} mm")
    if not damping_valid:
        limit = NEAR_MAXIMUM * peak_speed(float(tracker.z[Z.D1]), float(tracker.z[Z.D2]))
        if abs(tracker.speed) >= limit:
            lines.append(f"damping: the damper is at its maximum beyond {1e3 * limit:.1f} mm/s; move slower")
        else:
            lines.append("damping: not yet known; move at different speeds up to a few mm/s")
    if not known.d2:
        lines.append("d2: not observable at this speed; move faster than half the damper's maximum")
    if not known.inertia:
        lines.append("inertia: not observable at this excitation; move with two tones above 0.7 Hz")
    if not known.force_offset:
        lines.append("force_offset: not yet known; move over several millimetres")
    if not known.coulomb_friction:
        lines.append("coulomb_friction: not yet known; reverse the motion")
    return tuple(lines)
