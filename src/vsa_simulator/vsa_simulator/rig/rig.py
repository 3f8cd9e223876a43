# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The rig: advance it, read its sensors and its ground truth."""

import math
from typing import NamedTuple

import numpy as np
from vsa_common.config.configuration import ConfigurationError
from vsa_common.types import Array
from vsa_simulator.rig.config import RigConfig, TorqueConfig
from vsa_simulator.rig.dynamics import ANGLE, Q1, Q2, STATES, TRUTH, X1, X2, advance_rig, balanced_travels
from vsa_simulator.rig.motion import motion_from, position
from vsa_simulator.rig.motors import CommandWatchdog
from vsa_simulator.rig.parameters import Command, Joint, Load, Model, Steps, curves_of, record_of
from vsa_simulator.rig.sensors import Readings, Sensors
from vsa_simulator.rig.transmission import spring_deflection, spring_force, substeps_for, transmission_from


class Samples(NamedTuple):
    """Consecutive samples: number of the first, truth rows (columns as in `TRUTH`), readings."""

    first: int
    truth: Array
    readings: Readings


class Rig:
    """The antagonistic joint with its motors and sensors.

    >>> rig = Rig(RigConfig())
    >>> samples = rig.advance(1000)
    >>> samples.truth[:, TRUTH.index("force_1")].mean().round(1), samples.readings.counts.shape
    (np.float64(29.2), (1000, 2))
    """

    def __init__(self, config: RigConfig) -> None:
        self.config = config
        self.sample = 0  # number of the next sample
        self._model = model_from(config)
        self._sensors = Sensors(config.sensors, config.sensor_errors, config.rate_hz, config.seed)
        rate_hz = config.rate_hz * self._sensors.oversampling
        substeps = max(substeps_for(rate_hz, side) for side in self._model.transmissions)
        self._record = record_of(self._model, Steps(substeps, 1.0 / (rate_hz * substeps)))
        self._curves = curves_of(self._model)
        self._motors = CommandWatchdog(config.motors.watchdog)
        self._state = self._equilibrium()

    @property
    def time(self) -> float:
        """Time of the next sample since the start [s]."""
        return self.sample / self.config.rate_hz

    @property
    def motors(self) -> tuple[float, float]:
        """Motor positions at the next sample [rad]."""
        radius = self.config.motors.pulley_radius
        return self._state[Q1] / radius, self._state[Q2] / radius

    @property
    def holding(self) -> bool:
        """Whether the motors hold their position because commands have stopped."""
        return self._motors.holding

    def command(self, motor_1: float, motor_2: float) -> None:
        """Command motor positions [rad]; the first command ends the profile."""
        self._motors.command(self.time, (motor_1, motor_2))

    def set_disturbance(self, torque: float) -> None:
        """Apply an external torque besides that of the configuration, from the next sample on [N m]."""
        self._record["torque_disturbance"] = torque

    def advance(self, samples: int) -> Samples:
        """The next `samples` samples. The motors' watchdog acts at their beginning."""
        target = self._motors.update(self.time, self.motors)
        radius = self.config.motors.pulley_radius
        travel_1, travel_2 = (radius * target[0], radius * target[1]) if target else (0.0, 0.0)
        self._record["command"] = Command(target is not None, travel_1, travel_2)
        first, rows = self.sample, self._sensors.oversampling
        truth = np.empty((samples * rows, len(TRUTH)))
        tones, table = self._model.load.tones, self._model.motion.table
        advance_rig(self._state, self._record, self._curves, tones, table, first * rows, truth)
        self.sample += samples
        return Samples(first, truth[::rows], self._sensors.read(truth))

    def _equilibrium(self) -> Array:
        (one, other), joint = self._model.transmissions, self._model.joint
        start, torque, travels = position(0.0, self._model.motion), self.config.torque.constant, np.empty(2)
        balanced_travels(start, torque, (one, other), joint, travels)
        force_2 = spring_force(start, one) + 2.0 * torque / joint.radius
        if force_2 <= other.force_offset:
            raise ConfigurationError(f"torque.constant = {torque} N m: transmission 2 would go slack")
        state = np.zeros(STATES)
        state[ANGLE] = joint.equilibrium_angle
        state[X1], state[X2] = start, spring_deflection(force_2, other)
        state[Q1], state[Q2] = travels
        return state


def model_from(config: RigConfig) -> Model:
    """The model of a configuration. Raises ConfigurationError for inconsistent values."""
    return Model(
        (
            transmission_from(config.transmission_1, config),
            transmission_from(config.transmission_2, config),
        ),
        _joint_from(config),
        Load(config.torque.constant, 0.0, _torque_tones(config.torque), config.torque.fade_in),
        motion_from(config.profile),
    )


def _joint_from(config: RigConfig) -> Joint:
    joint, motors = config.joint, config.motors
    if motors.lower_limit >= motors.upper_limit:
        raise ConfigurationError(
            f"motors.lower_limit = {motors.lower_limit} rad: must be below upper_limit, {motors.upper_limit} rad"
        )
    return Joint(
        radius=joint.radius,
        inertia=joint.inertia,
        damping=joint.damping,
        equilibrium_angle=joint.equilibrium_angle,
        motor_bandwidth=2.0 * math.pi * motors.bandwidth,
        speed_limit=motors.pulley_radius * motors.speed_limit,
        lower_limit=motors.pulley_radius * motors.lower_limit,
        upper_limit=motors.pulley_radius * motors.upper_limit,
        motor_radius=motors.pulley_radius,
    )


def _torque_tones(config: TorqueConfig) -> Array:
    if not len(config.amplitudes) == len(config.frequencies) == len(config.phases):
        raise ConfigurationError("torque.amplitudes, frequencies and phases: expected as many values of each")
    return np.array(list(zip(config.amplitudes, config.frequencies, config.phases, strict=True)))
