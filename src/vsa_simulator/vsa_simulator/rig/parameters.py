# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parameters of the rig for the integrator: named tuples in compiled code, one record at its boundary.

A call of compiled code with a named tuple costs half a microsecond a field, with a record array as little as one array.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_simulator.laws.curve import Curve
from vsa_simulator.laws.friction import Friction
from vsa_simulator.rig.motion import Motion, Table
from vsa_simulator.rig.transmission import Transmission

Pair = tuple[Transmission, Transmission]
Curves = tuple[Curve, Curve, Curve, Curve]  # spring and damper of transmission 1, of transmission 2
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


_CURVES = ("spring", "damper")  # the last fields of a transmission
_FRICTION = np.dtype(list(Friction.__annotations__.items()))
_TRANSMISSION = np.dtype(
    [
        (name, _FRICTION if name == "friction" else kind)
        for name, kind in Transmission.__annotations__.items()
        if name not in _CURVES
    ]
)
_FIELDS = {
    "transmission_1": _TRANSMISSION,
    "transmission_2": _TRANSMISSION,
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
    for side, transmission in zip(("transmission_1", "transmission_2"), model.transmissions, strict=True):
        record[side][0] = transmission[: -len(_CURVES)]
    record["joint"][0], record["steps"][0] = model.joint, steps
    record["torque_constant"], record["torque_disturbance"] = model.load.constant, model.load.disturbance
    record["torque_fade_in"] = model.load.fade_in
    record["motion_centre"], record["motion_kind"] = model.motion.centre, model.motion.kind
    record["motion_fade_in"] = model.motion.fade_in
    return record


def curves_of(model: Model) -> Curves:
    """The laws of both transmissions, spring and damper each."""
    (one, two) = model.transmissions
    return one.spring, one.damper, two.spring, two.damper


@compiled
def model_of(r: np.void, curves: Curves, tones: Array, table: Table) -> Model:
    """The model of a record, with the curves of its laws, the tones of its torque and the table of its motion."""
    return Model(
        (
            _transmission_of(r["transmission_1"], curves[0], curves[1]),
            _transmission_of(r["transmission_2"], curves[2], curves[3]),
        ),
        _joint_of(r["joint"]),
        Load(r["torque_constant"], r["torque_disturbance"], tones, r["torque_fade_in"]),
        Motion(r["motion_centre"], int(r["motion_kind"]), table, r["motion_fade_in"]),
    )


@compiled
def _transmission_of(r: np.void, spring: Curve, damper: Curve) -> Transmission:
    return Transmission(
        force_offset=r["force_offset"],
        k1=r["k1"],
        k2=r["k2"],
        d1=r["d1"],
        d2=r["d2"],
        inertia=r["inertia"],
        tendon_stiffness=r["tendon_stiffness"],
        peak_speed=r["peak_speed"],
        greatest_damping=r["greatest_damping"],
        greatest_stiffness=r["greatest_stiffness"],
        drift=r["drift"],
        share=r["share"],
        time_constant=r["time_constant"],
        hysteresis=r["hysteresis"],
        hysteresis_travel=r["hysteresis_travel"],
        hysteresis_shape=r["hysteresis_shape"],
        exponential=r["exponential"],
        cubic=r["cubic"],
        friction=_friction_of(r["friction"]),
        spring=spring,
        damper=damper,
    )


@compiled
def _friction_of(r: np.void) -> Friction:
    return Friction(
        kind=r["kind"],
        coulomb=r["coulomb"],
        smoothing_speed=r["smoothing_speed"],
        bristle_stiffness=r["bristle_stiffness"],
        bristle_damping=r["bristle_damping"],
        static=r["static"],
        stribeck_speed=r["stribeck_speed"],
        dip=r["dip"],
        dip_speed=r["dip_speed"],
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
