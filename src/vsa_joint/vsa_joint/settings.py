"""Parameters of the joint: geometry with its uncertainty, reflection, pairing and limits."""

from dataclasses import dataclass
from typing import Any

from vsa_common.config.configuration import ConfigurationError, choice, quantities, quantity
from vsa_joint.impedance.propagation import RouteStd
from vsa_joint.impedance.reflection import Joint, TendonPath

CONSISTENT, PAPER = "consistent", "paper"


def per_side(default: float, unit: str, low: float, high: float, text: str) -> Any:
    """A quantity of each transmission, transmission_1 first."""
    return quantities((default, default), unit, low, high, text)


@dataclass(frozen=True)
class Limits:
    """What the tendons and transmissions bear; the reachable stiffness and the controller stay within."""

    slack_margin: float = quantity(3.0, "N", 0.0, 1e3, "rod force above F0 that keeps a tendon from slack")
    force_max: float = quantity(190.0, "N", 1.0, 1e5, "greatest rod force, twice the tendon tension")
    deflection_max: float = quantity(0.02, "m", 1e-4, 1.0, "greatest deflection of a transmission")


@dataclass(frozen=True)
class Geometry:
    """How the transmissions reach the joint, and how well that is known."""

    radius: tuple[float, float] = per_side(0.0215, "m", 1e-3, 1.0, "mean radius of the joint's capstan pulley")
    radius_std: tuple[float, float] = per_side(
        0.0, "m", 0.0, 0.1, "standard deviation of radius; one error for both sides"
    )
    tendon_stiffness: tuple[float, float] = per_side(1e5, "N/m", 1e2, 1e9, "stiffness of the tendon over its length")
    tendon_stiffness_std: tuple[float, float] = per_side(
        0.0, "N/m", 0.0, 1e9, "standard deviation of tendon_stiffness; one error for both sides"
    )
    joint_damping: float = quantity(0.01, "N m s/rad", 0.0, 1e3, "damping of the joint without its transmissions")
    joint_inertia: float = quantity(1e-3, "kg m^2", 0.0, 1e3, "inertia of the joint without its transmissions")

    def __post_init__(self) -> None:
        for name in ("radius", "radius_std", "tendon_stiffness", "tendon_stiffness_std"):
            if len(getattr(self, name)) != 2:
                given = list(getattr(self, name))
                raise ConfigurationError(f"{name} = {given!r}: must be two numbers, one a transmission")

    @property
    def joint(self) -> Joint:
        """The geometry for the reflection."""
        first, second = (TendonPath(r, k) for r, k in zip(self.radius, self.tendon_stiffness, strict=True))
        return Joint((first, second), self.joint_damping, self.joint_inertia)

    @property
    def std(self) -> tuple[RouteStd, RouteStd]:
        """Its uncertainty for the propagation."""
        first, second = (RouteStd(r, k) for r, k in zip(self.radius_std, self.tendon_stiffness_std, strict=True))
        return first, second


@dataclass(frozen=True)
class Motors:
    """How far the motors wind up the tendons."""

    motor_pulley_radius: float = quantity(0.010, "m", 1e-4, 1.0, "tendon travel per radian of a motor")
    motor_min: float = quantity(-3.0, "rad", -1e4, 1e4, "least motor position")
    motor_max: float = quantity(8.0, "rad", -1e4, 1e4, "greatest motor position")


@dataclass(frozen=True)
class JointConfig(Geometry, Limits, Motors):
    """Parameters of the joint node."""

    reflection: str = choice(CONSISTENT, (CONSISTENT, PAPER), "how damping and inertia of the rods reach the joint")
    max_skew: float = quantity(0.02, "s", 1e-6, 10.0, "most time between the stamps of a pair")
    stale_timeout: float = quantity(0.05, "s", 1e-3, 60.0, "silence after which the joint is STALE; at least 5 periods")
    status_period: float = quantity(0.02, "s", 1e-3, 1.0, "period of the watch on silent transmissions")


@dataclass(frozen=True)
class ControlConfig(Geometry, Limits, Motors):
    """Parameters of the stiffness controller."""

    rate: float = quantity(100.0, "Hz", 10.0, 1000.0, "of motor commands")
    rest_time: float = quantity(0.1, "s", 1e-3, 10.0, "time constant of a step of the equilibrium")
    smoothing_time: float = quantity(0.055, "s", 1e-3, 10.0, "time constant of a step of stiffness by a factor 2")
    stiffness_gain: float = quantity(2.0, "1/s", 0.0, 20.0, "integral gain on the logarithm of the stiffness")
    equilibrium_gain: float = quantity(0.5, "", 0.0, 5.0, "proportional gain on the unloaded equilibrium")
    equilibrium_integral: float = quantity(2.0, "1/s", 0.0, 20.0, "integral gain on the unloaded equilibrium")
    dead_band: float = quantity(0.003, "rad", 0.0, 0.1, "error of the equilibrium that is left alone")
    correction_max: float = quantity(0.3, "rad", 0.0, 3.0, "most that the loop moves the equilibrium")
    load_time: float = quantity(1.0, "s", 0.01, 60.0, "time over which the external torque counts as steady load")
    error_warn: float = quantity(0.05, "", 0.0, 10.0, "predicted relative error of the stiffness from which on to warn")
    error_max: float = quantity(0.3, "", 0.0, 10.0, "predicted relative error of the stiffness from which on to refuse")
    input_timeout: float = quantity(0.07, "s", 0.01, 10.0, "age of the joint's estimate at which motors hold")
    frozen_timeout: float = quantity(
        0.5, "s", 0.0, 60.0, "time after which a force that repeats to the last digit counts as frozen; 0: never"
    )
    command_timeout: float = quantity(0.5, "s", 0.01, 60.0, "silence of stiffness_command after which motors hold")
    dither_amplitude: float = quantity(0.0, "m", 0.0, 0.005, "most that self-excitation may move a rod; 0: never")
    dither_frequency: float = quantity(0.2, "Hz", 0.01, 10.0, "of the self-excitation")
    dither_error: float = quantity(0.02, "", 1e-4, 10.0, "predicted error of the stiffness that calls for excitation")
