# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parameters of the joint node and the stiffness controller."""

from dataclasses import dataclass
from typing import Any

from vsa_common.config.configuration import FRAME_PREFIX, ConfigurationError, choice, quantities, quantity, string
from vsa_joint.geometry import Joint, TendonPath, TendonPathStd

CONSISTENT, PAPER = "consistent", "paper"
SIMULATED_RECOVERY_AMPLITUDE = 5e-4  # [m] of a simulated joint, where no person has to be protected from a motion


def per_transmission(default: float, unit: str, low: float, high: float, text: str) -> Any:
    """A quantity per transmission: transmission_1, transmission_2."""
    return quantities((default, default), unit, low, high, text)


@dataclass(frozen=True)
class Limits:
    """Limits of tendons and transmissions for the reachable stiffness and the controller."""

    slack_margin: float = quantity(3.0, "N", 0.0, 1e3, "least force above F0, so that no tendon is slack", tunable=True)
    force_max: float = quantity(
        190.0, "N", 1.0, 1e5, "greatest force of a transmission, twice the tendon tension", tunable=True
    )
    deflection_max: float = quantity(0.02, "m", 1e-4, 1.0, "greatest deflection of a transmission", tunable=True)


@dataclass(frozen=True)
class Geometry:
    """Geometry of the tendons and of the joint, with standard deviations."""

    radius: tuple[float, float] = per_transmission(0.0215, "m", 1e-3, 1.0, "mean radius of the joint's capstan pulley")
    radius_std: tuple[float, float] = per_transmission(
        0.0, "m", 0.0, 0.1, "standard deviation of radius; one common error of both"
    )
    tendon_stiffness: tuple[float, float] = per_transmission(
        1e5, "N/m", 1e2, 1e9, "stiffness of the tendon over its length"
    )
    tendon_stiffness_std: tuple[float, float] = per_transmission(
        0.0, "N/m", 0.0, 1e9, "standard deviation of tendon_stiffness; one common error of both"
    )
    joint_damping: float = quantity(0.01, "N m s/rad", 0.0, 1e3, "damping of the joint without its transmissions")
    joint_inertia: float = quantity(1e-3, "kg m^2", 0.0, 1e3, "inertia of the joint without its transmissions")

    def __post_init__(self) -> None:
        for name in ("radius", "radius_std", "tendon_stiffness", "tendon_stiffness_std"):
            if len(getattr(self, name)) != 2:
                given = list(getattr(self, name))
                raise ConfigurationError(f"{name} = {given!r}: must be two numbers, one per transmission")

    @property
    def joint(self) -> Joint:
        """Geometry for the reflection to the joint."""
        first, second = (TendonPath(r, k) for r, k in zip(self.radius, self.tendon_stiffness, strict=True))
        return Joint((first, second), self.joint_damping, self.joint_inertia)

    @property
    def std(self) -> tuple[TendonPathStd, TendonPathStd]:
        """Standard deviations for the propagation of variances."""
        first, second = (TendonPathStd(r, k) for r, k in zip(self.radius_std, self.tendon_stiffness_std, strict=True))
        return first, second


@dataclass(frozen=True)
class Motors:
    """Travel of the motors."""

    motor_pulley_radius: float = quantity(0.010, "m", 1e-4, 1.0, "tendon travel per radian of a motor")
    motor_min: float = quantity(-3.0, "rad", -1e4, 1e4, "least motor position", tunable=True)
    motor_max: float = quantity(8.0, "rad", -1e4, 1e4, "greatest motor position", tunable=True)


@dataclass(frozen=True)
class JointConfig(Geometry, Limits, Motors):
    """Parameters of the joint node."""

    frame_prefix: str = string("", FRAME_PREFIX)
    joint_name: str = string("joint", "frame_id of joint_impedance after frame_prefix: joint.name of the driver")
    reflection: str = choice(
        CONSISTENT,
        (CONSISTENT, PAPER),
        "reflection of damping and inertia to the joint: by virtual work, or as printed",
    )
    max_skew: float = quantity(0.02, "s", 1e-6, 10.0, "greatest difference between the stamps of a pair", tunable=True)
    stale_timeout: float = quantity(
        0.05, "s", 1e-3, 60.0, "time without a pair after which the joint is STALE; at least 5 periods", tunable=True
    )
    status_period: float = quantity(0.02, "s", 1e-3, 1.0, "period of the timeout check", tunable=True)


@dataclass(frozen=True)
class ControlConfig(Geometry, Limits, Motors):
    """Parameters of the stiffness controller."""

    rate: float = quantity(100.0, "Hz", 10.0, 1000.0, "rate of motor commands", tunable=True)
    rest_time: float = quantity(
        0.1, "s", 1e-3, 10.0, "time constant of the three lags of the equilibrium set-point filter", tunable=True
    )
    smoothing_time: float = quantity(
        0.04, "s", 1e-3, 10.0, "time constant of the three lags of the stiffness set-point filter", tunable=True
    )
    motor_speed: float = quantity(
        3.5,
        "rad/s",
        0.01,
        100.0,
        "speed limit of a motor's set-point in a change of the stiffness, or of the equilibrium",
        tunable=True,
    )
    stiffness_gain: float = quantity(
        2.0, "1/s", 0.0, 20.0, "integral gain on the logarithm of the stiffness", tunable=True
    )
    equilibrium_gain: float = quantity(0.5, "", 0.0, 5.0, "proportional gain on the unloaded equilibrium", tunable=True)
    equilibrium_integral: float = quantity(
        2.0, "1/s", 0.0, 20.0, "integral gain on the unloaded equilibrium", tunable=True
    )
    dead_band: float = quantity(0.003, "rad", 0.0, 0.1, "dead band of the error of the equilibrium", tunable=True)
    correction_max: float = quantity(0.3, "rad", 0.0, 3.0, "limit of the correction of the equilibrium", tunable=True)
    load_time: float = quantity(
        1.0, "s", 0.01, 60.0, "time constant of the filter of the external torque", tunable=True
    )
    error_warn: float = quantity(
        0.05,
        "",
        0.0,
        10.0,
        "predicted relative error of the stiffness above which a command is accepted with a warning",
        tunable=True,
    )
    error_max: float = quantity(
        0.3, "", 0.0, 10.0, "predicted relative error of the stiffness above which a command is refused", tunable=True
    )
    input_timeout: float = quantity(
        0.07,
        "s",
        0.01,
        10.0,
        "silence of the joint estimate at which the motors hold; at that age by its stamp, control without feedback",
        tunable=True,
    )
    frozen_timeout: float = quantity(
        0.5, "s", 0.0, 60.0, "time after which a bit-identical force is a frozen sensor; 0: never", tunable=True
    )
    command_timeout: float = quantity(
        0.5, "s", 0.01, 60.0, "time without stiffness_command after which the motors hold", tunable=True
    )
    dither_amplitude: float = quantity(
        0.0, "m", 0.0, 0.005, "greatest amplitude of the self-excitation of a transmission; 0: none", tunable=True
    )
    dither_frequency: float = quantity(0.2, "Hz", 0.01, 10.0, "frequency of the self-excitation", tunable=True)
    dither_error: float = quantity(
        0.02,
        "",
        1e-4,
        10.0,
        "predicted relative error of the stiffness above which self-excitation is active",
        tunable=True,
    )
    law_error_max: float = quantity(
        0.05,
        "",
        0.0,
        1.0,
        "predicted relative error of the stiffness by the last valid law up to which control goes on without feedback"
        " while the stiffness is invalid; 0: never",
        tunable=True,
    )
    law_drift: float = quantity(
        0.02, "1/sqrt(s)", 1e-4, 1.0, "growth of that error since the stiffness was valid", tunable=True
    )
    recovery_amplitude: float = quantity(
        0.0,
        "m",
        0.0,
        0.002,
        "greatest amplitude of a transmission in the re-excitation of an invalid stiffness; 0: the motors hold instead",
        tunable=True,
    )
    recovery_frequency: float = quantity(1.0, "Hz", 0.1, 5.0, "frequency of the re-excitation", tunable=True)
    recovery_speed: float = quantity(
        0.5, "rad/s", 0.01, 10.0, "greatest speed of a motor in the re-excitation", tunable=True
    )
    recovery_angle: float = quantity(
        0.01, "rad", 1e-3, 0.2, "motion of the unloaded joint within which the re-excitation remains", tunable=True
    )
