"""Parameters of the joint: geometry with its uncertainty, reflection, pairing and limits."""

from dataclasses import dataclass
from typing import Any

from vsa_common.configuration import ConfigurationError, choice, quantities, quantity

from vsa_joint.propagation import RouteStd
from vsa_joint.reflection import Joint, Route

CONSISTENT, PAPER = "consistent", "paper"


def per_side(default: float, unit: str, low: float, high: float, text: str) -> Any:
    """A quantity of each transmission, transmission_1 first."""
    return quantities((default, default), unit, low, high, text)


@dataclass(frozen=True)
class Limits:
    """What the tendons and transmissions bear; the reachable stiffness and the controller stay within."""

    slack_margin: float = quantity(3.0, "N", 0.0, 1e3, "rod force above the force offset F0 below which a tendon is slack")
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
                raise ConfigurationError(f"{name} = {list(getattr(self, name))!r}: must be two numbers, one a transmission")

    @property
    def joint(self) -> Joint:
        """The geometry for the reflection."""
        first, second = (Route(r, k) for r, k in zip(self.radius, self.tendon_stiffness, strict=True))
        return Joint((first, second), self.joint_damping, self.joint_inertia)

    @property
    def std(self) -> tuple[RouteStd, RouteStd]:
        """Its uncertainty for the propagation."""
        first, second = (RouteStd(r, k) for r, k in zip(self.radius_std, self.tendon_stiffness_std, strict=True))
        return first, second


@dataclass(frozen=True)
class JointConfig(Geometry, Limits):
    """Parameters of the joint node."""

    reflection: str = choice(CONSISTENT, (CONSISTENT, PAPER), "how damping and inertia of the rods reach the joint")
    max_skew: float = quantity(0.005, "s", 1e-6, 10.0, "most time between the stamps of a pair")
    stale_timeout: float = quantity(0.05, "s", 1e-3, 60.0, "silence after which the joint is STALE; at least 5 periods")
    status_period: float = quantity(0.02, "s", 1e-3, 1.0, "period of the watch on silent transmissions")
