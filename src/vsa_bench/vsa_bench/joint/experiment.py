"""One run: learn while the motors move, hold them, let the external torque work, compare."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from vsa_bench.joint.case import (
    JUDGED_FREQUENCY,
    Case,
    estimator_config,
    external_torque,
    geometry,
    joint_config,
    rig_config,
    travel,
)
from vsa_bench.joint.operating_point import Place, rods_of
from vsa_common.types import Array
from vsa_estimator.estimator import Estimator
from vsa_estimator.output.estimate import Estimate
from vsa_joint.experiment.excitation import PERIOD
from vsa_joint.experiment.identification import Identified, average, from_motion, from_response, line_response
from vsa_joint.impedance.fusion import JointEstimate, JointFusion
from vsa_joint.impedance.pairing import TransmissionEstimate
from vsa_joint.impedance.propagation import ImpedanceEstimate
from vsa_joint.impedance.reflection import Impedance, as_printed, response, valid_frequency, virtual_work
from vsa_simulator.rig.config import RigConfig
from vsa_simulator.rig.dynamics import TRUTH
from vsa_simulator.rig.rig import Rig

LEARNING, SETTLING, PERIODS = 36.0, 4.0, 2  # s, s, periods used; one more is dropped before them
COMMAND_RATE_HZ = 100
HIGH_FORCE, UP, DOWN = 60.0, 2.0, 0.3  # N; the learning motion goes up by a factor, above HIGH_FORCE down
LEARNING_FREQUENCY = (1.0 / 18.0, 1.0 / 3.0)  # Hz, whole turns within LEARNING


@dataclass(frozen=True)
class Response:
    """Torque over angle at each frequency [Hz], measured and predicted [N m/rad]."""

    frequency: Array
    measured: NDArray[np.complex128]
    predicted: NDArray[np.complex128]

    @property
    def error(self) -> float:
        """Greatest relative error."""
        return float(np.abs(self.measured / self.predicted - 1.0).max())


@dataclass(frozen=True)
class Outcome:
    """The rig's truth, the independent experiment, and the live estimate, each with standard deviations."""

    case: Case
    co_contraction: float  # N, the smaller mean tension
    torque_rms: float  # N m
    truth: Impedance
    printed: Impedance  # the truth's (12) and (13)
    identified: Identified
    estimated: Impedance
    estimated_std: Impedance
    expansion_valid: bool
    response: Response | None  # a joint with friction has none


@dataclass(frozen=True)
class Recording:
    """Truth (columns as in TRUTH) and what the sensors said."""

    truth: Array
    forces: Array
    deflections: Array
    angle: Array
    torque: Array


def run(case: Case) -> Outcome:
    """The whole experiment on a rig of its own."""
    config = rig_config(case)
    recording = record(case, config)
    used = slice(-round(PERIODS * PERIOD * case.rate_hz), None)
    period = average(recording.angle[used], recording.torque[used], case.rate_hz, PERIOD)
    torque, joint = external_torque(case, config), geometry(config)
    rods = rods_of(recording.truth[used].mean(axis=0))
    measured = None
    if case.frictionless:
        z = line_response(period, torque.lines)
        measured = Response(torque.frequency, z, response(torque.frequency, rods, joint))
        identified = from_response(torque.frequency, z, joint)
    else:
        identified = from_motion(period, joint)
    first = len(recording.angle) + used.start
    estimates = {_row(e, case): e for e in estimate(recording, config)}
    chosen = [row for row in estimates if row >= first]
    live, truth = [estimates[row] for row in chosen], recording.truth[chosen]
    place = Place(truth, case.frictionless)
    reflected = [place.at_rest([by(rods_of(row), joint) for row in truth]) for by in (virtual_work, as_printed)]
    tension = recording.truth[used][:, [TRUTH.index("tension_1"), TRUTH.index("tension_2")]].mean(axis=0)
    valid = valid_frequency(rods, joint) >= JUDGED_FREQUENCY
    return Outcome(
        case, float(tension.min()), torque.rms, reflected[0], reflected[1], identified,
        place.at_rest(live), place.std(live), valid, measured,
    )  # fmt: skip


def record(case: Case, config: RigConfig) -> Recording:
    """Motors up and down together for a while, then held."""
    rig, parts = Rig(config), []
    sides = (config.transmission_1, config.transmission_2)
    for k in range(round((LEARNING + SETTLING) * COMMAND_RATE_HZ)):
        force = _learning_force(k / COMMAND_RATE_HZ, case.force)
        rig.command(*(travel(force, side) / config.motors.pulley_radius for side in sides))
        parts.append(rig.advance(case.rate_hz // COMMAND_RATE_HZ))
    parts.append(rig.advance(round((1 + PERIODS) * PERIOD * case.rate_hz)))
    counts = np.concatenate([part.readings.counts for part in parts])
    turns = np.unwrap(counts, period=1 << 16, axis=0) - config.sensors.encoder_start
    return Recording(
        np.concatenate([part.truth for part in parts]),
        np.concatenate([part.readings.forces for part in parts]),
        turns * config.sensors.deflection_resolution,
        np.concatenate([part.readings.angle for part in parts]),
        np.concatenate([part.readings.torque for part in parts]),
    )


def estimate(recording: Recording, config: RigConfig) -> list[JointEstimate]:
    """What both estimators and the joint core give, sample by sample."""
    fusion = JointFusion(joint_config(config))
    coefficients = (config.transmission_1, config.transmission_2)
    estimators = [Estimator(estimator_config(c, config, side)) for side, c in enumerate(coefficients)]
    out = []
    for k in range(len(recording.angle)):
        stamp = (k + 1) * 1_000_000_000 // config.rate_hz
        for side, estimator in enumerate(estimators):
            sample = estimator.add(stamp, recording.forces[k, side], recording.deflections[k, side])
            if sample is None:
                continue
            joint = fusion.add(side, joint_side(sample), stamp)
            if joint is not None:
                out.append(joint)
    return out


def joint_side(e: Estimate) -> TransmissionEstimate:
    """What the joint core needs of an estimate."""
    rod = ImpedanceEstimate(
        e.stiffness, e.damping, e.inertia, e.stiffness_variance, e.damping_variance, e.inertia_variance,
        e.stiffness_damping_covariance, e.stiffness_inertia_covariance, e.damping_inertia_covariance,
    )  # fmt: skip
    return TransmissionEstimate(
        e.stamp_ns, e.force, e.force_variance, e.force_valid, rod, e.stiffness_valid, e.damping_valid,
        e.inertia_valid, e.status, e.reset_count, e.reset_reason,
    )  # fmt: skip


def _learning_force(time: float, held: float) -> float:
    """Rod force asked of both sides [N]: from `held` and back, again and again, and at last to stay."""
    if time >= LEARNING:
        return held
    turned = UP if held <= HIGH_FORCE else DOWN
    slow, quick = (1.0 - math.cos(2.0 * math.pi * f * time) for f in LEARNING_FREQUENCY)
    return held * turned ** (0.475 * slow + 0.025 * quick)


def _row(estimate: JointEstimate, case: Case) -> int:
    return round(estimate.stamp_ns * 1e-9 * case.rate_hz) - 1
