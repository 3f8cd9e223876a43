# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parameters of a case, and the configurations of rig, joint and estimators that follow from it."""

import math
from dataclasses import dataclass, replace

import numpy as np
from vsa_common.config.configuration import build
from vsa_common.damper import peak_speed
from vsa_estimator.settings import EstimatorConfig
from vsa_joint.experiment.excitation import FRICTION_LINES, RESPONSE_LINES, Multisine, largest_multisine, multisine
from vsa_joint.geometry import Joint, TendonPath
from vsa_joint.impedance.reflection import Impedance, Transmissions
from vsa_joint.settings import JointConfig
from vsa_simulator.laws.config import ForceLaws
from vsa_simulator.laws.springs import EXPONENTIAL, SpringConfig
from vsa_simulator.rig.config import RigConfig, TorqueConfig, TransmissionConfig
from vsa_simulator.rig.transmission import spring_deflection, stiffness, transmission_from

RATE_HZ, EXACT_RATE_HZ = 200, 1000  # the second for lines up to 20 Hz
SMALL_TORQUE = 0.02  # N m rms, without friction
FILTER_RATE_HZ, EXACT_FILTER_RATE_HZ = 100.0, 500.0
EXACT_FORCE, EXACT_DEFLECTION = 1e-3, 1e-7  # N, m, noise in the configuration of an estimator with exact sensors
TORQUE_FADE_IN = 40.0  # s, during the excitation of the estimators
TOP_EVALUATED_FREQUENCY = 0.65  # Hz, for stiffness and damping


@dataclass(frozen=True)
class Case:
    """Force while the motors are held [N], tendon [N/m], friction of both transmissions [N], and a seed."""

    force: float
    tendon_stiffness: float
    coulomb_friction: float
    seed: int
    spring: str = EXPONENTIAL  # elastic law of both transmissions

    @property
    def frictionless(self) -> bool:
        """Whether the linear response applies."""
        return self.coulomb_friction == 0.0

    @property
    def rate_hz(self) -> int:
        """Sampling rate [Hz]."""
        return EXACT_RATE_HZ if self.frictionless else RATE_HZ


def rig_config(case: Case) -> RigConfig:
    """Rig of a case with its external torque; exact sensors without friction."""
    rig = RigConfig()
    changes = {"tendon_stiffness": case.tendon_stiffness, "coulomb_friction": case.coulomb_friction}
    rig = replace(
        rig,
        rate_hz=case.rate_hz,
        seed=case.seed,
        spring=SpringConfig(case.spring),
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
    """Largest multisine that the predicted motion permits with friction; a small one without."""
    if case.frictionless:
        return multisine(RESPONSE_LINES, SMALL_TORQUE, case.seed)
    transmissions = transmissions_at_rest(case, rig)
    slowest = min(peak_speed(c.d1, c.d2) for c in (rig.transmission_1, rig.transmission_2))
    return largest_multisine(FRICTION_LINES, case.seed, transmissions, geometry(rig), slowest)


def transmissions_at_rest(case: Case, rig: RigConfig) -> Transmissions:
    """Impedance of both transmissions with held motors."""
    impedances = []
    for c in (rig.transmission_1, rig.transmission_2):
        p = transmission_from(c, rig)
        impedances.append(Impedance(stiffness(spring_deflection(case.force, p), p), c.d1, c.inertia))
    first, second = impedances
    return first, second


def geometry(rig: RigConfig) -> Joint:
    """True geometry of the rig."""
    first, second = (TendonPath(rig.joint.radius, c.tendon_stiffness) for c in (rig.transmission_1, rig.transmission_2))
    return Joint((first, second), rig.joint.damping, rig.joint.inertia)


def joint_config(rig: RigConfig) -> JointConfig:
    """Configuration of the joint fusion with the geometry of the rig."""
    return JointConfig(
        radius=(rig.joint.radius,) * 2,
        tendon_stiffness=(rig.transmission_1.tendon_stiffness, rig.transmission_2.tendon_stiffness),
        joint_damping=rig.joint.damping,
        joint_inertia=rig.joint.inertia,
    )


def estimator_config(coefficients: TransmissionConfig, rig: RigConfig, index: int) -> EstimatorConfig:
    """Estimator with initial errors: 30 % of k2, and of d1, d2, inertia; signs drawn from the seed."""
    generator = np.random.default_rng([rig.seed, index])
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


def travel(force: float, coefficients: TransmissionConfig, laws: ForceLaws) -> float:
    """Tendon travel [m] at which a transmission bears `force` [N] with the joint at zero."""
    deflection = spring_deflection(force, transmission_from(coefficients, laws))
    return 2.0 * deflection + force / (2.0 * coefficients.tendon_stiffness)
