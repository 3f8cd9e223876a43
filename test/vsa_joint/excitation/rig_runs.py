# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""A run of the procedure on the simulated rig with both estimators, without processes: time is that of the rig."""

import dataclasses

import numpy as np
from vsa_estimator.estimator import Estimator
from vsa_estimator.settings import EstimatorConfig, Initial
from vsa_joint.excitation.design import choose_motion
from vsa_joint.excitation.inputs import Inputs, Measurement
from vsa_joint.excitation.model import TransmissionModel
from vsa_joint.excitation.procedure import Procedure
from vsa_joint.excitation.settings import ExcitationConfig, Goal
from vsa_simulator.rig.config import RigConfig
from vsa_simulator.rig.motion import ProfileConfig
from vsa_simulator.rig.rig import Rig

RATE = 500
PERIOD = 0.01  # [s] of control
REST = 0.6  # [s] before the run
RESOLUTION = 1e-5
GOAL = Goal(("stiffness", "k2", "damping", "d2"), 0.0, duration=20.0, travel=0.0035, speed=0.005, force_max=190.0)
COVARIANCE = np.diag([0.7, 90.0, 2400.0, 1e8, 0.4, 10.0, 0.3]) ** 2


def model(**changes):
    """Transmission 1 of the paper with the standard deviations of paper_rig.yaml."""
    values = {
        "deflection_reference": 0.0105, "ln_stiffness": float(np.log(0.776 * 267.2) + 267.2 * 0.0105), "k2": 267.2,
        "d1": 4000.0, "d2": -1.089e8, "inertia": 0.3755, "force_offset": 16.39, "coulomb_friction": 0.3,
        "covariance": COVARIANCE, "force_noise_std": 0.017, "deflection_noise_std": 1.04e-5,
    }  # fmt: skip
    return TransmissionModel(**{**values, **changes})


def wrong_start(force, k2_std):
    """Start values with k2 and the stiffness too small by 30 and 50 %, damper coefficients wrong by 40 and 50 %."""
    k2 = 0.7 * (267.2 if k2_std > 80.0 else 165.6)
    offset = force - 0.5 / 0.7 * (force - (16.39 if k2_std > 80.0 else 8.269))
    return Initial(k2=k2, k2_std=k2_std, d1=2400.0, d2=-5.5e7, force_offset=offset, force_offset_std=10.0)


class Run:
    """One run; `step` is a control period, `finish` runs to the end."""

    def __init__(self, seed=0, goal=GOAL, config=None, choose=choose_motion):
        profile = ProfileConfig(kind="hold")
        self.rig = Rig(RigConfig(rate_hz=RATE, seed=seed, profile=profile))
        force = 16.39 + 0.776 * np.exp(267.2 * 0.0105)
        self.estimators = [Estimator(EstimatorConfig(initial=wrong_start(force, std))) for std in (90.0, 60.0)]
        self.inputs, self.choose = Inputs(sample_rates=[float(RATE)] * 2), choose
        self.forces, self.deflections, self.angles, self.motions = [], [], [], []
        while self.rig.time < REST:
            self.sense()
        self.procedure = Procedure(config or ExcitationConfig(), goal, self.inputs, self.now)

    @property
    def now(self):
        return round(self.rig.time * 1e9)

    def sense(self):
        """Advance the rig by one period and update the inputs."""
        samples = self.rig.advance(round(PERIOD * RATE))
        readings = samples.readings
        for i, estimator in enumerate(self.estimators):
            for time, force, count in zip(
                samples.truth[:, 0], readings.forces[:, i], readings.counts[:, i], strict=True
            ):
                estimator.add(round(1e9 * (1.0 + time)), float(force), RESOLUTION * float(count))
            self.inputs.measurements[i] = Measurement(
                float(readings.forces[-1, i]), RESOLUTION * float(readings.counts[-1, i]), 1, self.now, self.now
            )
            if len(self.forces) % 2 == 0:  # at 50 Hz, as the node
                self.inputs.states[i], self.inputs.states_ns[i] = estimator.state(), self.now
        self.inputs.motors, self.inputs.motors_ns = tuple(readings.motors[-1]), self.now
        self.inputs.angle, self.inputs.angle_ns = float(readings.angle[-1]), self.now
        self.forces.append(readings.forces[-1])
        self.deflections.append(samples.truth[-1, [1, 8]])
        self.angles.append(self.inputs.angle)

    def step(self):
        task = self.procedure.task(self.inputs, self.now)
        if task is not None:
            self.motions.append(self.choose(task).motion)
            self.procedure.begin_segment(self.motions[-1], self.now)
        positions = self.procedure.step(self.inputs, self.now)
        if self.procedure.outcome is None:
            self.rig.command(*positions)
            self.sense()
        return positions

    def finish(self):
        while self.procedure.outcome is None:
            self.step()
        return self.procedure.outcome


def ln_determinant(run, names=("ln_stiffness_reference", "k2", "d1", "d2")):
    """ln det of the estimators' covariances of the wanted coefficients, the sum of both transmissions."""
    order = ("ln_stiffness_reference", "k2", "d1", "d2", "inertia", "force_offset", "coulomb_friction")
    rows = [order.index(name) for name in names]
    total = 0.0
    for estimator in run.estimators:
        covariance = np.array(estimator.state().coefficient_covariance).reshape(7, 7)[np.ix_(rows, rows)]
        scale = np.sqrt(np.diag(covariance))
        total += np.linalg.slogdet(covariance / np.outer(scale, scale))[1] + 2.0 * np.log(scale).sum()
    return total


def changed(goal, **changes):
    """A goal with other values."""
    return dataclasses.replace(goal, **changes)
