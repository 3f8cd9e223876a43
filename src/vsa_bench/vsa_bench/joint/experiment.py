# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""One run: motors excite the estimators, then hold; the external torque identifies the joint; comparison."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from vsa_bench.joint.case import (
    TOP_EVALUATED_FREQUENCY,
    Case,
    estimator_config,
    external_torque,
    geometry,
    joint_config,
    rig_config,
    travel,
)
from vsa_bench.joint.operating_point import OperatingPoint, transmissions_of
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

EXCITATION, SETTLING, PERIODS = 36.0, 4.0, 2  # s, s, periods used after one that is discarded
COMMAND_RATE_HZ = 100
HIGH_FORCE, UP, DOWN = 60.0, 2.0, 0.3  # N; force ratio of the excitation up to HIGH_FORCE, and above
EXCITATION_FREQUENCY = (1.0 / 18.0, 1.0 / 3.0)  # Hz, whole periods within EXCITATION


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
    """Truth, independent identification and live estimate, the latter two with standard deviations."""

    case: Case
    co_contraction: float  # N, the smaller mean tension
    torque_rms: float  # N m
    truth: Impedance
    printed: Impedance  # eqs. (12) and (13) of the truth
    identified: Identified
    estimated: Impedance
    estimated_std: Impedance
    expansion_valid: bool
    response: Response | None  # None with friction


@dataclass(frozen=True)
class Recording:
    """Truth (columns as in TRUTH) and sensor readings, one row per sample: N, m, rad, N m."""

    truth: Array
    forces: Array
    deflections: Array
    angle: Array
    torque: Array


def run(case: Case) -> Outcome:
    """The whole experiment on a rig of its own."""
    config = rig_config(case)
    recording = record(case, config)
    used = used_rows(case)
    identified, measured = identify(case, config, recording, used)
    joint = geometry(config)
    first = len(recording.angle) + used.start
    estimates = {_row(e, case): e for e in estimate(recording, config)}
    chosen = [row for row in estimates if row >= first]
    live, truth = [estimates[row] for row in chosen], recording.truth[chosen]
    point = OperatingPoint(truth, case.frictionless)
    consistent, printed = (
        point.at_rest([reflection(transmissions_of(row), joint) for row in truth])
        for reflection in (virtual_work, as_printed)
    )
    mean = recording.truth[used].mean(axis=0)
    tension = recording.truth[used][:, [TRUTH.index("tension_1"), TRUTH.index("tension_2")]].mean(axis=0)
    return Outcome(
        case=case,
        co_contraction=float(tension.min()),
        torque_rms=external_torque(case, config).rms,
        truth=consistent,
        printed=printed,
        identified=identified,
        estimated=point.at_rest(live),
        estimated_std=point.std(live),
        expansion_valid=valid_frequency(transmissions_of(mean), joint) >= TOP_EVALUATED_FREQUENCY,
        response=measured,
    )


def used_rows(case: Case) -> slice:
    """Rows of a recording in the periods that are evaluated, from its end."""
    return slice(-round(PERIODS * PERIOD * case.rate_hz), None)


def identify(case: Case, config: RigConfig, recording: Recording, used: slice) -> tuple[Identified, Response | None]:
    """Impedance from torque and angle of the rows `used`, and the response of a joint without friction."""
    period = average(recording.angle[used], recording.torque[used], case.rate_hz, PERIOD)
    torque, joint = external_torque(case, config), geometry(config)
    if not case.frictionless:
        return from_motion(period, joint), None
    transmissions = transmissions_of(recording.truth[used].mean(axis=0))
    z = line_response(period, torque.lines)
    measured = Response(torque.frequency, z, response(torque.frequency, transmissions, joint))
    return from_response(torque.frequency, z, joint), measured


def record(case: Case, config: RigConfig) -> Recording:
    """Common motion of both motors, then held motors under the external torque."""
    rig, parts = Rig(config), []
    coefficients = (config.transmission_1, config.transmission_2)
    for k in range(round((EXCITATION + SETTLING) * COMMAND_RATE_HZ)):
        force = _excitation_force(k / COMMAND_RATE_HZ, case.force)
        rig.command(*(travel(force, c, config) / config.motors.pulley_radius for c in coefficients))
        parts.append(rig.advance(case.rate_hz // COMMAND_RATE_HZ))
    parts.append(rig.advance(round((1 + PERIODS) * PERIOD * case.rate_hz)))
    counts = np.concatenate([part.readings.counts for part in parts])
    turns = np.unwrap(counts, period=1 << 16, axis=0) - config.sensors.encoder_start
    return Recording(
        truth=np.concatenate([part.truth for part in parts]),
        forces=np.concatenate([part.readings.forces for part in parts]),
        deflections=turns * config.sensors.deflection_resolution,
        angle=np.concatenate([part.readings.angle for part in parts]),
        torque=np.concatenate([part.readings.torque for part in parts]),
    )


def estimate(recording: Recording, config: RigConfig) -> list[JointEstimate]:
    """Joint estimates of both estimators and the fusion, sample by sample."""
    fusion = JointFusion(joint_config(config))
    coefficients = (config.transmission_1, config.transmission_2)
    estimators = [Estimator(estimator_config(c, config, index)) for index, c in enumerate(coefficients)]
    out = []
    for k in range(len(recording.angle)):
        stamp = (k + 1) * 1_000_000_000 // config.rate_hz
        for index, estimator in enumerate(estimators):
            sample = estimator.add(stamp, recording.forces[k, index], recording.deflections[k, index])
            if sample is None:
                continue
            joint = fusion.add(index, transmission_estimate(sample), stamp)
            if joint is not None:
                out.append(joint)
    return out


def transmission_estimate(e: Estimate) -> TransmissionEstimate:
    """Input of the joint fusion from an estimate."""
    return TransmissionEstimate(
        stamp_ns=e.stamp_ns,
        force=e.force,
        force_variance=e.force_variance,
        force_valid=e.force_valid,
        impedance=ImpedanceEstimate(*(getattr(e, name) for name in ImpedanceEstimate._fields)),
        stiffness_valid=e.stiffness_valid,
        damping_valid=e.damping_valid,
        inertia_valid=e.inertia_valid,
        status=e.status,
        reset_count=e.reset_count,
        reset_reason=e.reset_reason,
    )


def _excitation_force(time: float, held: float) -> float:
    """Common force of both transmissions [N]: periodic from `held`, then constant at it."""
    if time >= EXCITATION:
        return held
    ratio = UP if held <= HIGH_FORCE else DOWN
    slow, fast = (1.0 - math.cos(2.0 * math.pi * f * time) for f in EXCITATION_FREQUENCY)
    return held * ratio ** (0.475 * slow + 0.025 * fast)


def _row(estimate: JointEstimate, case: Case) -> int:
    return round(estimate.stamp_ns * 1e-9 * case.rate_hz) - 1
