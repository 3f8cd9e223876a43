"""The rig as one object: advance it and read its sensors; the truth comes beside."""

import math
from typing import NamedTuple

import numpy as np
from vsa_common.config.configuration import ConfigurationError
from vsa_common.types import Array
from vsa_simulator.rig.config import MotorConfig, RigConfig, TorqueConfig
from vsa_simulator.rig.dynamics import (
    ANGLE,
    PUSH,
    Q1,
    Q2,
    STATES,
    TRUTH,
    X1,
    X2,
    Joint,
    Load,
    advance_rig,
    balanced_travels,
    rig_numbers,
)
from vsa_simulator.rig.motion import motion_from, position
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
        self.push = 0.0  # external torque besides that of the configuration [N m]
        self._p = (
            transmission_from(config.transmission_1, config.friction),
            transmission_from(config.transmission_2, config.friction),
        )
        self._j = _joint_from(config)
        self._motion = motion_from(config.profile)
        self._tones = _torque_tones(config.torque)
        load = Load(config.torque.constant, 0.0, self._tones, config.torque.fade_in)
        self._numbers = rig_numbers(self._p, self._j, load, self._motion)
        self._substeps = max(substeps_for(config.rate_hz, side) for side in self._p)
        self._step = 1.0 / (config.rate_hz * self._substeps)
        self._sensors = Sensors(config.sensors, config.seed)
        self._motors = MotorPort(config.motors)
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
        """Whether the motors hold because commands have stopped."""
        return self._motors.holding

    def command(self, motor_1: float, motor_2: float) -> None:
        """Send the motors to these positions [rad]; from the first command on the profile is out."""
        self._motors.command(self.time, (motor_1, motor_2))

    def advance(self, samples: int) -> Samples:
        """The next `samples` samples. The motors' watchdog looks at the beginning."""
        wanted = self._motors.wanted(self.time, self.motors)
        travels = np.array(wanted or (0.0, 0.0)) * self.config.motors.pulley_radius
        truth, first = np.empty((samples, len(TRUTH))), self.sample
        self._numbers[PUSH] = self.push
        advance_rig(
            self._state,
            first,
            self._substeps,
            self._step,
            self._numbers,
            self._tones,
            self._motion.table,
            wanted is not None,
            travels,
            truth,
        )
        self.sample += samples
        return Samples(first, truth, self._sensors.read(truth))

    def _equilibrium(self) -> Array:
        start, torque, travels = position(0.0, self._motion), self.config.torque.constant, np.empty(2)
        balanced_travels(start, torque, self._p, self._j, travels)
        force_2 = spring_force(start, self._p[0]) + 2.0 * torque / self.config.joint.radius
        if force_2 <= self.config.transmission_2.force_offset:
            raise ConfigurationError(f"torque.constant = {torque} N m: transmission 2 would go slack")
        state = np.zeros(STATES)
        state[ANGLE] = self.config.joint.equilibrium_angle
        state[X1], state[X2] = start, spring_deflection(force_2, self._p[1])
        state[Q1], state[Q2] = travels
        return state


class MotorPort:
    """Takes commands and holds where it is when they stop; time is an argument, seconds since the start."""

    def __init__(self, config: MotorConfig) -> None:
        self._config = config
        self._command: tuple[float, float] | None = None
        self._commanded_at = 0.0
        self.holding = False

    def command(self, time: float, positions: tuple[float, float]) -> None:
        """Take a command [rad] and release a hold."""
        self._command, self._commanded_at, self.holding = positions, time, False

    def wanted(self, time: float, positions: tuple[float, float]) -> tuple[float, float] | None:
        """Where the motors, now at `positions`, shall go [rad]; None before the first command."""
        overdue = time - self._commanded_at > self._config.watchdog
        if self._command is not None and overdue and not self.holding:
            self._command, self.holding = positions, True
        return self._command


def _joint_from(config: RigConfig) -> Joint:
    joint, motors = config.joint, config.motors
    if motors.lower_limit >= motors.upper_limit:
        raise ConfigurationError(
            f"motors.lower_limit = {motors.lower_limit} rad: must be below upper_limit, {motors.upper_limit} rad"
        )
    return Joint(
        joint.radius,
        joint.inertia,
        joint.damping,
        joint.equilibrium_angle,
        2.0 * math.pi * motors.bandwidth,
        motors.pulley_radius * motors.speed_limit,
        motors.pulley_radius * motors.lower_limit,
        motors.pulley_radius * motors.upper_limit,
        motors.pulley_radius,
    )


def _torque_tones(config: TorqueConfig) -> Array:
    if not len(config.amplitudes) == len(config.frequencies) == len(config.phases):
        raise ConfigurationError("torque.amplitudes, frequencies and phases: expected as many values of each")
    return np.array(list(zip(config.amplitudes, config.frequencies, config.phases, strict=True)))
