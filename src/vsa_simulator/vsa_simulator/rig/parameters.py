"""Parameters of the rig for the integrator: named tuples in compiled code, one record at its boundary.

A call of compiled code with a named tuple costs half a microsecond a field, with a record array as little as one array.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_simulator.rig.motion import Motion, Table
from vsa_simulator.rig.transmission import Transmission

Pair = tuple[Transmission, Transmission]
Record = NDArray[np.void]  # (1,) of RECORD


class Joint(NamedTuple):
    """Shaft and motors; SI, speed and position of the motors as travel of their tendons."""

    radius: float
    inertia: float
    damping: float
    equilibrium_angle: float
    motor_bandwidth: float  # [rad/s]
    speed_limit: float  # [m/s]
    lower_limit: float  # [m]
    upper_limit: float  # [m]
    motor_radius: float


class Load(NamedTuple):
    """External torque: a constant that the motors balance, a disturbance [N m], and tones (amplitude, Hz, phase)."""

    constant: float
    disturbance: float
    tones: Array
    fade_in: float


class Model(NamedTuple):
    """The whole rig."""

    transmissions: Pair
    joint: Joint
    load: Load
    motion: Motion


class Steps(NamedTuple):
    """Integration steps of one sample and their length [s]."""

    per_sample: int
    length: float


class Command(NamedTuple):
    """Commanded tendon travels [m], where `active`."""

    active: bool
    travel_1: float
    travel_2: float


_FIELDS = {
    "transmission_1": np.dtype(list(Transmission.__annotations__.items())),
    "transmission_2": np.dtype(list(Transmission.__annotations__.items())),
    "joint": np.dtype(list(Joint.__annotations__.items())),
    "command": np.dtype(list(Command.__annotations__.items())),
    "steps": np.dtype(list(Steps.__annotations__.items())),
    "torque_constant": np.dtype(float),
    "torque_disturbance": np.dtype(float),
    "torque_fade_in": np.dtype(float),
    "motion_centre": np.dtype(float),
    "motion_kind": np.dtype(int),
    "motion_fade_in": np.dtype(float),
}
RECORD = np.dtype(list(_FIELDS.items()))


def record_of(model: Model, steps: Steps) -> Record:
    """The scalar parameters of a model, without command."""
    record = np.zeros(1, RECORD)
    record["transmission_1"][0], record["transmission_2"][0] = model.transmissions
    record["joint"][0], record["steps"][0] = model.joint, steps
    record["torque_constant"], record["torque_disturbance"] = model.load.constant, model.load.disturbance
    record["torque_fade_in"] = model.load.fade_in
    record["motion_centre"], record["motion_kind"] = model.motion.centre, model.motion.kind
    record["motion_fade_in"] = model.motion.fade_in
    return record


@compiled
def model_of(r: np.void, tones: Array, table: Table) -> Model:
    """The model of a record, with the tones of its torque and the table of its motion."""
    return Model(
        (_transmission_of(r["transmission_1"]), _transmission_of(r["transmission_2"])),
        _joint_of(r["joint"]),
        Load(r["torque_constant"], r["torque_disturbance"], tones, r["torque_fade_in"]),
        Motion(r["motion_centre"], int(r["motion_kind"]), table, r["motion_fade_in"]),
    )


@compiled
def _transmission_of(r: np.void) -> Transmission:
    return Transmission(
        force_offset=r["force_offset"],
        k1=r["k1"],
        k2=r["k2"],
        d1=r["d1"],
        d2=r["d2"],
        coulomb_friction=r["coulomb_friction"],
        inertia=r["inertia"],
        tendon_stiffness=r["tendon_stiffness"],
        peak_speed=r["peak_speed"],
        sticks=r["sticks"],
        smoothing_speed=r["smoothing_speed"],
        bristle_stiffness=r["bristle_stiffness"],
        bristle_damping=r["bristle_damping"],
        static_friction=r["static_friction"],
        stribeck_speed=r["stribeck_speed"],
    )


@compiled
def _joint_of(r: np.void) -> Joint:
    return Joint(
        radius=r["radius"],
        inertia=r["inertia"],
        damping=r["damping"],
        equilibrium_angle=r["equilibrium_angle"],
        motor_bandwidth=r["motor_bandwidth"],
        speed_limit=r["speed_limit"],
        lower_limit=r["lower_limit"],
        upper_limit=r["upper_limit"],
        motor_radius=r["motor_radius"],
    )
