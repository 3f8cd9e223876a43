"""What the filter says of the impedance between two of its steps, and whether that is to be relied on."""

import numpy as np
from vsa_common.accel import compiled
from vsa_estimator.excitation import DOUBTS
from vsa_estimator.filter import report
from vsa_estimator.model import Array
from vsa_estimator.steps import FOUND, parts

STIFFNESS = 0.1  # greatest relative standard deviation of a valid stiffness
DAMPING = 0.15  # of a valid damping, relative to D, or to a fifth of d1 where D vanishes
NEAR_MAXIMUM = 0.9  # damping is known up to this fraction of v*
FAR = 16.0  # squared standard deviations
BRIDGED = 0.25  # silence up to this long is predicted across [s]

IS_FAR, ASTRAY = range(2)  # whether the last deflection was far from the prediction; the square of that [m^2]

Assessment = tuple[
    float, float, bool, float, float, bool, float, float, bool, float, float, bool, float, float, bool,
    float, float, bool, float, float, float,
]  # fmt: skip


@compiled
def assess(
    known: Array, seen: Array, reference: float, ahead: float, jerk_density: float, deflection: float,
    noise_variance: float, heard: bool, trusted: bool, knows: bool, inertia_known: bool,
) -> Assessment:  # fmt: skip
    """Fields deflection to damping_inertia_covariance of an Estimate, `ahead` [s] of the last step.

    A `deflection` [m] with white noise of that variance is held against the prediction, NaN is none: where two in a row
    are far from it nobody knows yet whether the rod is there.
    """
    z, pull, p = parts(known)
    out = np.empty(16)
    report(z, p, pull, reference, min(max(ahead, 0.0), BRIDGED), jerk_density, known[FOUND + DOUBTS :], out)
    place_variance, ln_variance, damping, damping_variance = out[1], out[7], out[8], out[9]
    if not np.isnan(deflection):
        apart = deflection - out[0]
        square = apart * apart
        far = square > FAR * (place_variance + noise_variance)
        seen[ASTRAY] = square if far and seen[IS_FAR] > 0.0 else 0.0
        seen[IS_FAR] = 1.0 if far else 0.0
    if seen[ASTRAY] > 0.0:
        place_variance += seen[ASTRAY]
        ln_variance += z[4] * z[4] * seen[ASTRAY]
    stiffness = out[6]
    stiffness_valid = trusted and ln_variance < STIFFNESS * STIFFNESS
    tolerance = DAMPING * max(abs(damping), 0.2 * z[5])
    slow = abs(out[2]) < NEAR_MAXIMUM * out[15]
    damping_valid = trusted and knows and slow and damping_variance < tolerance * tolerance
    return (
        float(out[0]), float(place_variance), heard, float(out[2]), float(out[3]), heard,
        float(out[4]), float(out[5]), heard, float(stiffness), float(stiffness * stiffness * ln_variance),
        bool(stiffness_valid), float(damping), float(damping_variance), bool(damping_valid),
        float(out[10]), float(out[11]), trusted and inertia_known, float(out[12]), float(out[13]), float(out[14]),
    )  # fmt: skip
