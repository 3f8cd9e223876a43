# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Cases of `./vsa bench estimation`: rigs, motions of the simulated rig, noise, start values."""

from dataclasses import dataclass, replace
from itertools import product

from vsa_common.damper import peak_speed


@dataclass(frozen=True)
class Coefficients:
    """True coefficients of one transmission, eqs. (2) and (5), SI."""

    force_offset: float  # F0 [N]
    k1: float  # [N]
    k2: float  # [1/m]
    d1: float  # [N s/m]
    d2: float  # [N s^3/m^3]
    coulomb_friction: float  # d0 [N]
    inertia: float  # [kg]

    @property
    def maximum_speed(self) -> float:
        """Speed v* [m/s] at which the damper force is greatest; beyond it the force is constant."""
        return peak_speed(self.d1, self.d2)


# Eq. (20) with d2 and m of Table I; d1 and d0 are not in the paper.
RIGS = {
    "paper": {
        "transmission_1": Coefficients(16.39, 0.776, 267.2, 4000.0, -1.089e8, 0.3, 0.3755),
        "transmission_2": Coefficients(8.269, 7.031, 165.6, 4000.0, -1.170e8, 0.3, 0.2295),
    },
    "other": {
        "transmission_1": Coefficients(12.0, 2.0, 220.0, 2500.0, -0.5e8, 0.5, 0.6),
        "transmission_2": Coefficients(20.0, 1.2, 240.0, 5500.0, -1.8e8, 0.2, 0.3),
    },
}
HEAVY_INERTIA = 5.0  # [kg], of the heavy rod


FORCE_NOISE = {0.01: 0.017, 0.1: 0.13}  # section VI read as standard deviations, and as variances [mm -> N]


@dataclass(frozen=True)
class Case:
    """One row of the bench; the fields are the keys of its JSON."""

    transmission: str = "transmission_1"
    rig: str = "paper"
    coulomb_friction_n: float = 0.3
    motion: str = "multisine"
    mass: str = "light"
    rate_hz: int = 100
    deflection_noise_mm: float = 0.01
    force_noise_n: float = 0.017
    start: str = "bad"

    @property
    def coefficients(self) -> Coefficients:
        """The truth of this case."""
        base = RIGS[self.rig][self.transmission]
        inertia = HEAVY_INERTIA if self.mass == "heavy" else base.inertia
        return replace(base, coulomb_friction=self.coulomb_friction_n, inertia=inertia)

    @property
    def label(self) -> str:
        """Name in tables: what differs from the defaults."""
        parts = [
            "T" + self.transmission[-1] if self.rig == "paper" else f"{self.rig} T{self.transmission[-1]}",
            self.motion,
        ]
        parts += [self.mass] * (self.mass != "light") + [f"{self.rate_hz} Hz"] * (self.rate_hz != 100)
        parts += [f"{self.deflection_noise_mm:g} mm"] * (self.deflection_noise_mm != 0.01)
        parts += [f"d0 {self.coulomb_friction_n:g}"] * (
            self.coulomb_friction_n != default_friction(self.rig, self.transmission)
        )
        return " ".join([*parts, *([self.start] * (self.start != "bad"))])


def default_friction(rig: str, transmission: str) -> float:
    """Coulomb friction of a rig [N], the default of its cases."""
    return RIGS[rig][transmission].coulomb_friction


def case(transmission: str = "transmission_1", motion: str = "multisine", **changes: object) -> Case:
    """A case; friction defaults to the rig's own, force noise to FORCE_NOISE of the deflection noise."""
    rig = str(changes.get("rig", "paper"))
    changes.setdefault("coulomb_friction_n", default_friction(rig, transmission))
    changes.setdefault("force_noise_n", FORCE_NOISE.get(float(str(changes.get("deflection_noise_mm", 0.01))), 0.017))
    return Case(transmission=transmission, motion=motion, **changes)  # type: ignore[arg-type]


QUICK = (
    case(motion="multisine"),
    case(motion="slow", coulomb_friction_n=0.0, start="good"),
)
DEFAULT = (
    *(
        case(side, motion)
        for motion, side in product(("slow", "slow2", "multisine"), ("transmission_1", "transmission_2"))
    ),
    *(case(motion=motion, rig="other") for motion in ("slow", "slow2", "multisine")),
    *(case(motion=motion) for motion in ("half_hz", "fast", "dwells", "one_hz")),
    case(motion="multisine", rate_hz=1000),
    case("transmission_1", "slow", mass="heavy"),
    case("transmission_2", "slow", mass="heavy"),
    case(motion="slow", deflection_noise_mm=0.1),
    case(motion="multisine", deflection_noise_mm=0.1),
    case(motion="slow", coulomb_friction_n=0.0, start="good"),
)
