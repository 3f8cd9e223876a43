"""What the filter says of the impedance between two of its steps, and whether that is to be relied on."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_common.types import Array, Status
from vsa_estimator.filter.output_prediction import predict_output
from vsa_estimator.filter.records import PREDICTION, Record
from vsa_estimator.force_law.elastic import ln_stiffness_gradient
from vsa_estimator.force_law.state import D1, K2
from vsa_estimator.output.estimate import ROW
from vsa_estimator.preprocessing.pipeline import preprocess
from vsa_estimator.preprocessing.validation import ACCEPT

Moments = NDArray[np.int64]

STIFFNESS = 0.1  # greatest relative standard deviation of a valid stiffness
PARTED = 0.25  # of d1, with which a stiffness is valid before the filter takes over: else it may be the damper's
DAMPING = 0.15  # of a valid damping, relative to D, or to a fifth of d1 where D vanishes
NEAR_MAXIMUM = 0.9  # damping is known up to this fraction of v*
FAR = 16.0  # squared standard deviations
MAX_PREDICTION_TIME = 0.25  # silence up to this long is predicted across [s]

FAST_PATH = 3  # beside the verdicts of `intake`: taken, with nothing to heed, and assessed

# What is believed until the next step, in an array: whether it is complete; of the last deflection whether it was far
# from the prediction, and the square of that [m^2]; the reference [m], the jerk density, the deflection's noise [m^2];
# whether the coefficients are doubted, learnt, and tell the mass. From BEHIND on the last fields of an Estimate.
HOLDS, IS_FAR, ASTRAY, REFERENCE, JERK_DENSITY, NOISE_VARIANCE, DOUBTED, KNOWS, INERTIA_KNOWN, BEHIND = range(10)
FIELDS = ROW.index(
    "reset_count"
)  # of a row, the first ones are assessed; those behind are the same until the next step
SNAPSHOT = BEHIND + len(ROW) - FIELDS
# And in whole numbers [ns]: the instant of the last step, and until when sensors are complained of.
STEP, COMPLAINED = range(2)

CONVERGING, VALID, DEGRADED, STALE = (
    int(one) for one in (Status.CONVERGING, Status.VALID, Status.DEGRADED, Status.STALE)
)

Assessment = tuple[
    bool, float, float, bool, float, float, bool, float, float, bool, float, float, bool, float, float, bool,
    float, float, bool, float, float, float, int,
]  # fmt: skip


@compiled
def predict_into(
    row: Array, state: Record, beliefs: Array, moments: Moments, stamp_ns: int, instant_ns: int, deflection: float,
    heard: bool, blind: bool, stale: bool,
) -> None:  # fmt: skip
    """Fields force_valid to status of an Estimate at an instant [ns], flags as 0 and 1.

    A `deflection` [m] is held against the prediction, NaN is none: where two in a row are far from it nobody knows yet
    whether the rod is there. `heard` says that sensors still tell, `blind` that the encoder is not to be believed.
    """
    z, p = state[0]["mean"], state[0]["covariance"]
    prediction = np.empty(1, PREDICTION)
    ahead = min(max((instant_ns - moments[STEP]) * 1e-9, 0.0), MAX_PREDICTION_TIME)
    predict_output(state, beliefs[REFERENCE], ahead, beliefs[JERK_DENSITY], prediction)
    out = prediction[0]
    position_variance, ln_variance = out["deflection_variance"], out["ln_stiffness_variance"]
    damping, damping_variance = out["damping"], out["damping_variance"]
    if not np.isnan(deflection):
        apart = deflection - out["deflection"]
        square = apart * apart
        far = square > FAR * (position_variance + beliefs[NOISE_VARIANCE])
        beliefs[ASTRAY] = square if far and beliefs[IS_FAR] > 0.0 else 0.0
        beliefs[IS_FAR] = 1.0 if far else 0.0
    if beliefs[ASTRAY] > 0.0:
        position_variance += beliefs[ASTRAY]
        by_x = ln_stiffness_gradient(z[K2], 0.0)[0]
        ln_variance += by_x * by_x * beliefs[ASTRAY]
    doubted, knows = beliefs[DOUBTED] > 0.0, beliefs[KNOWS] > 0.0
    complaining = doubted or stamp_ns < moments[COMPLAINED]
    trusted = heard and not (doubted or blind)
    stiffness = out["stiffness"]
    parted = knows or p[D1, D1] < (PARTED * z[D1]) ** 2
    stiffness_valid = trusted and parted and ln_variance < STIFFNESS * STIFFNESS
    tolerance = DAMPING * max(abs(damping), 0.2 * z[D1])
    damping_valid = trusted and knows and damping_variance < tolerance * tolerance
    row[0] = heard and not complaining
    row[1], row[2], row[3] = out["deflection"], position_variance, heard
    row[4], row[5], row[6] = out["velocity"], out["velocity_variance"], heard
    row[7], row[8], row[9] = out["acceleration"], out["acceleration_variance"], heard
    row[10], row[11], row[12] = stiffness, stiffness * stiffness * ln_variance, stiffness_valid
    row[13], row[14] = damping, damping_variance
    row[15] = damping_valid and abs(out["velocity"]) < NEAR_MAXIMUM * out["peak_speed"]
    row[16], row[17], row[18] = out["inertia"], out["inertia_variance"], trusted and beliefs[INERTIA_KNOWN] > 0.0
    row[19], row[20] = out["stiffness_damping_covariance"], out["stiffness_inertia_covariance"]
    row[21] = out["damping_inertia_covariance"]
    if stale:
        row[22] = STALE
    elif complaining and knows:
        row[22] = DEGRADED
    else:
        row[22] = VALID if stiffness_valid else CONVERGING


@compiled
def as_tuple(row: Array) -> Assessment:
    """A row of `assess_into` as Python's own kinds."""
    return (
        row[0] > 0.0, float(row[1]), float(row[2]), row[3] > 0.0, float(row[4]), float(row[5]), row[6] > 0.0,
        float(row[7]), float(row[8]), row[9] > 0.0, float(row[10]), float(row[11]), row[12] > 0.0,
        float(row[13]), float(row[14]), row[15] > 0.0, float(row[16]), float(row[17]), row[18] > 0.0,
        float(row[19]), float(row[20]), float(row[21]), int(row[22]),
    )  # fmt: skip


@compiled
def predict_row(
    state: Record, beliefs: Array, moments: Moments, stamp_ns: int, instant_ns: int, deflection: float,
    heard: bool, blind: bool, stale: bool,
) -> Assessment:  # fmt: skip
    """As `assess_into`."""
    row = np.empty(FIELDS)
    predict_into(row, state, beliefs, moments, stamp_ns, instant_ns, deflection, heard, blind, stale)
    return as_tuple(row)


@compiled
def process_into(
    row: Array, pipeline_state: NDArray[Any], state: Record, beliefs: Array, moments: Moments,
    stamp_ns: int, force: float, deflection: float,
) -> tuple[int, int, int, int]:  # fmt: skip
    """`take` a sample and, where no step is due and its signs say nothing, FOLLOWED: assessed into the row as well."""
    verdict, found, instant_ns, blocks = preprocess(pipeline_state, stamp_ns, force, deflection)
    if verdict == ACCEPT and not found and not blocks and beliefs[HOLDS] > 0.0:
        verdict = FAST_PATH
        predict_into(row, state, beliefs, moments, stamp_ns, instant_ns, deflection, True, False, False)
    return verdict, found, instant_ns, blocks


@compiled
def process_sample(
    pipeline_state: NDArray[Any], state: Record, beliefs: Array, moments: Moments,
    stamp_ns: int, force: float, deflection: float,
) -> tuple[int, int, int, int, Assessment]:  # fmt: skip
    """As `follow_into`; the assessment means something with FOLLOWED alone."""
    row = np.zeros(FIELDS)
    verdict, found, instant_ns, blocks = process_into(
        row, pipeline_state, state, beliefs, moments, stamp_ns, force, deflection
    )
    return verdict, found, instant_ns, blocks, as_tuple(row)


@compiled
def process_samples(
    rows: Array, pipeline_state: NDArray[Any], state: Record, beliefs: Array, moments: Moments,
    stamp_ns: Moments, force: Array, deflection: Array, first: int, end: int,
) -> tuple[int, int, int, int, int]:  # fmt: skip
    """`follow_into` samples from `first` on up to one that is not FOLLOWED; which, and what is said of it.

    The last fields of an Estimate go into the rows, too.
    """
    for i in range(first, end):
        verdict, found, instant_ns, blocks = process_into(
            rows[i, :FIELDS], pipeline_state, state, beliefs, moments, stamp_ns[i], force[i], deflection[i]
        )
        if verdict != FAST_PATH:
            return i, verdict, found, instant_ns, blocks
        rows[i, FIELDS:] = beliefs[BEHIND:]
    return end, FAST_PATH, 0, 0, 0
