# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parameters of the excitation node, and the limits of one run."""

from dataclasses import dataclass

from vsa_common.config.configuration import ConfigurationError, quantity
from vsa_joint.settings import Motors, per_transmission


@dataclass(frozen=True)
class ExcitationConfig(Motors):
    """Parameters of the excitation node; a goal may have smaller limits."""

    radius: tuple[float, float] = per_transmission(0.0215, "m", 1e-3, 1.0, "mean radius of the joint's capstan pulley")
    travel: float = quantity(
        0.0035, "m", 1e-5, 1.0, "greatest change of the mean deflection of both transmissions", tunable=True
    )
    speed: float = quantity(0.005, "m/s", 1e-5, 1.0, "greatest speed of the mean deflection", tunable=True)
    duration: float = quantity(60.0, "s", 1.0, 3600.0, "greatest duration", tunable=True)
    force_max: float = quantity(
        190.0, "N", 1.0, 1e5, "greatest force of a transmission, twice the tendon tension", tunable=True
    )
    deflection_min: float = quantity(5e-4, "m", -1.0, 1.0, "least deflection of a transmission", tunable=True)
    deflection_max: float = quantity(0.02, "m", 1e-4, 1.0, "greatest deflection of a transmission", tunable=True)
    angle_max: float = quantity(0.3, "rad", 1e-3, 10.0, "greatest turn of the joint from its start", tunable=True)
    rate: float = quantity(100.0, "Hz", 10.0, 1000.0, "rate of motor commands", tunable=True)
    input_timeout: float = quantity(
        0.2, "s", 0.01, 10.0, "time without valid measurements after which the motion ends", tunable=True
    )

    def __post_init__(self) -> None:
        if len(self.radius) != 2:
            raise ConfigurationError(f"radius = {list(self.radius)!r}: must be two numbers, one per transmission")


@dataclass(frozen=True)
class Goal:
    """What one run is to find, within which limits, SI."""

    quantities: tuple[str, ...]
    relative_interval: float  # half of the 95 % interval over the value; 0: validity suffices
    duration: float
    travel: float
    speed: float
    force_max: float
