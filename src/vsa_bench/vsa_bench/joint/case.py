"""What is varied from run to run, and the rig and the estimators that follow from it."""

import math
from dataclasses import dataclass, replace

import numpy as np
from vsa_common.config.configuration import build
from vsa_estimator.settings import EstimatorConfig
from vsa_joint.experiment.excitation import FRICTION_LINES, RESPONSE_LINES, Multisine, largest, multisine
from vsa_joint.impedance.reflection import Impedance, Joint, Sides, TendonPath
from vsa_joint.settings import JointConfig
from vsa_simulator.rig.config import RigConfig, TorqueConfig, TransmissionConfig

RATE_HZ, EXACT_RATE_HZ = 200, 1000  # the second where lines up to 20 Hz must not pass for noise
SMALL_TORQUE = 0.02  # N m rms, without friction
FILTER_RATE_HZ, EXACT_FILTER_RATE_HZ = 100.0, 500.0
EXACT_FORCE, EXACT_DEFLECTION = 1e-3, 1e-7  # N, m, noise that an estimator of exact sensors is told
TORQUE_FADE_IN = 40.0  # s, while the motors move for the estimators
JUDGED_FREQUENCY = 0.65  # Hz, up to which stiffness and damping are compared


@dataclass(frozen=True)
class Case:
    """Rod force while the motors are held [N], tendon [N/m], friction of both rods [N], and a seed."""

    force: float
    tendon_stiffness: float
    coulomb_friction: float
    seed: int

    @property
    def frictionless(self) -> bool:
        """Whether the plain response can be used."""
        return self.coulomb_friction == 0.0

    @property
    def rate_hz(self) -> int:
        """Samples a second."""
        return EXACT_RATE_HZ if self.frictionless else RATE_HZ


def rig_config(case: Case) -> RigConfig:
    """The rig of a case, with its external torque; exact sensors of angle and torque where there is no friction."""
    rig = RigConfig()
    changes = {"tendon_stiffness": case.tendon_stiffness, "coulomb_friction": case.coulomb_friction}
    rig = replace(
        rig,
        rate_hz=case.rate_hz,
        seed=case.seed,
        transmission_1=replace(rig.transmission_1, **changes),
        transmission_2=replace(rig.transmission_2, **changes),
    )
    if case.frictionless:
        exact = {"angle_noise_std": 0.0, "torque_noise_std": 0.0, "force_noise_std": 0.0, "deflection_noise_std": 0.0}
        fine = {"force_resolution": 0.0, "deflection_resolution": 1e-8}
        rig = replace(rig, sensors=replace(rig.sensors, **exact, **fine, encoder_start=0))
    torque = external_torque(case, rig)
    tones = TorqueConfig(
        amplitudes=(torque.amplitude,) * len(torque.lines),
        frequencies=tuple(float(f) for f in torque.frequency),
        phases=tuple(phase + 0.5 * math.pi - 2.0 * math.pi * (phase > math.pi) for phase in torque.phases),
        fade_in=TORQUE_FADE_IN,
    )
    return replace(rig, torque=tones)


def external_torque(case: Case, rig: RigConfig) -> Multisine:
    """As large as the predicted motion allows with friction; small without."""
    if case.frictionless:
        return multisine(RESPONSE_LINES, SMALL_TORQUE, case.seed)
    sides = rods_at_rest(case, rig)
    slowest = min(math.sqrt(c.d1 / (-3.0 * c.d2)) for c in (rig.transmission_1, rig.transmission_2))
    return largest(FRICTION_LINES, case.seed, sides, geometry(rig), slowest)


def rods_at_rest(case: Case, rig: RigConfig) -> Sides:
    """Both rods as the motors hold them."""
    first, second = (
        Impedance(c.k2 * (case.force - c.force_offset), c.d1, c.inertia)
        for c in (rig.transmission_1, rig.transmission_2)
    )
    return first, second


def geometry(rig: RigConfig) -> Joint:
    """The rig's own geometry."""
    first, second = (TendonPath(rig.joint.radius, c.tendon_stiffness) for c in (rig.transmission_1, rig.transmission_2))
    return Joint((first, second), rig.joint.damping, rig.joint.inertia)


def joint_config(rig: RigConfig) -> JointConfig:
    """What the joint core is told about the rig."""
    return JointConfig(
        radius=(rig.joint.radius,) * 2,
        tendon_stiffness=(rig.transmission_1.tendon_stiffness, rig.transmission_2.tendon_stiffness),
        joint_damping=rig.joint.damping,
        joint_inertia=rig.joint.inertia,
    )


def estimator_config(coefficients: TransmissionConfig, rig: RigConfig, side: int) -> EstimatorConfig:
    """An estimator that starts wrong: k2 by 30 %, d1, d2 and inertia off, drawn from the seed."""
    generator = np.random.default_rng([rig.seed, side])
    k2 = coefficients.k2 * generator.choice([0.7, 1.3])
    start = {
        "k2": k2,
        "k2_std": 0.3 * k2,
        "d1": coefficients.d1 * generator.choice([0.6, 1.6]),
        "d2": 0.5 * coefficients.d2,
        "inertia": 2.0 * coefficients.inertia,
        "force_offset": coefficients.force_offset * 0.8,
        "force_offset_std": 0.5 * coefficients.force_offset,
    }
    return build(
        EstimatorConfig,
        {f"initial.{name}": float(value) for name, value in start.items()}
        | {
            "filter_rate": EXACT_FILTER_RATE_HZ if rig.rate_hz == EXACT_RATE_HZ else FILTER_RATE_HZ,
            "deflection_resolution": rig.sensors.deflection_resolution,
            "force_noise_std": max(rig.sensors.force_noise_std, EXACT_FORCE),
            "deflection_noise_std": max(rig.sensors.deflection_noise_std, EXACT_DEFLECTION),
        },
    )


def travel(force: float, coefficients: TransmissionConfig) -> float:
    """Tendon travel at which a rod bears `force` with the joint at zero [m]."""
    deflection = math.log((force - coefficients.force_offset) / coefficients.k1) / coefficients.k2
    return 2.0 * deflection + force / (2.0 * coefficients.tendon_stiffness)
