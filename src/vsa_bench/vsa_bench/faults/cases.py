# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Cases of `./vsa bench faults`: faults, lasting and transient, and healthy motion."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

from vsa_bench.faults import hypotheses
from vsa_bench.faults.motions import CENTRE_M, FAULT_MOTIONS, HEALTHY_MOTIONS
from vsa_bench.faults.stamps import STAMPS
from vsa_simulator.laws.config import ForceLaws
from vsa_simulator.laws.dampers import DamperConfig
from vsa_simulator.laws.friction import FrictionConfig
from vsa_simulator.laws.springs import SpringConfig
from vsa_simulator.rig.config import SecondTransmissionConfig, TransmissionConfig
from vsa_simulator.rig.recording import TransmissionVariant

RATES_HZ = (100, 500, 1000)
LASTING, TRANSIENT = math.inf, 2.0  # duration of a fault [s]
BURST_S = 0.05  # the longest that samples are late
STIFFER, STEEPER = 1.3, 1.2  # factors of k1 and of k2 of a changed transmission

PAPER = TransmissionConfig()
CHANGED = {
    "stiffness_changed": replace(PAPER, k1=STIFFER * PAPER.k1),
    "k2_changed": replace(  # with the same elastic force in the centre
        PAPER, k2=STEEPER * PAPER.k2, k1=PAPER.k1 * math.exp((1.0 - STEEPER) * PAPER.k2 * CENTRE_M)
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Fault:
    """A fault: `failure` in the syntax of the rig's failures, empty where stamps or transmission change.

    `hypothesis` is the one that the estimator has to name; `durations` [s] and `motions` are those of its cases.
    """

    hypothesis: str
    failure: str = ""
    durations: tuple[float, ...] = (LASTING, TRANSIENT)
    motions: tuple[str, ...] = FAULT_MOTIONS


_MOVING = tuple(one for one in FAULT_MOTIONS if one != "rest")
FAULTS = {
    "force_bias_1n": Fault(hypotheses.FORCE_OFFSET, "force wrong -v 1"),
    "force_bias_5n": Fault(hypotheses.FORCE_OFFSET, "force wrong -v 5"),
    "force_drift_0.1n": Fault(hypotheses.FORCE_OFFSET, "force drift -v 0.1", (LASTING,)),
    "force_drift_0.5n": Fault(hypotheses.FORCE_OFFSET, "force drift -v 0.5"),
    "force_stuck": Fault(hypotheses.FORCE_STUCK, "force stuck"),
    "force_noisy": Fault(hypotheses.FORCE_NOISY, "force noise -v 10"),
    "force_saturated": Fault(hypotheses.SATURATION, "force saturated"),
    "encoder_step_0.3mm": Fault(hypotheses.ENCODER_STEP, "encoder wrong -v 0.0003"),
    "encoder_step_1mm": Fault(hypotheses.ENCODER_STEP, "encoder wrong -v 0.001"),
    "encoder_step_4mm": Fault(hypotheses.ENCODER_STEP, "encoder wrong -v 0.004"),
    "encoder_stuck": Fault(hypotheses.ENCODER_STUCK, "encoder stuck"),
    "encoder_noisy": Fault(hypotheses.ENCODER_NOISY, "encoder noise -v 10"),
    "encoder_saturated": Fault(hypotheses.SATURATION, "encoder saturated"),
    "stamps_burst": Fault(hypotheses.STAMPS_LATE, durations=(BURST_S,)),
    "stamps_late": Fault(hypotheses.STAMPS_LATE, durations=(TRANSIENT,)),
    **{name: Fault(hypotheses.TRANSMISSION_CHANGED, durations=(LASTING,), motions=_MOVING) for name in CHANGED},
}


@dataclass(frozen=True)
class FaultCase:
    """A fault of `duration` [s] in a motion."""

    fault: str
    duration: float
    motion: str
    rate_hz: int

    @property
    def label(self) -> str:
        """Name in lists.

        >>> FaultCase("force_stuck", 2.0, "mix", 100).label
        'force_stuck 2 s mix 100 Hz'
        """
        return f"{self.fault} {form(self.duration)} {self.motion} {self.rate_hz} Hz"


def form(duration: float) -> str:
    """Duration of a fault as a text."""
    return f"{duration:g} s" if math.isfinite(duration) else "lasting"


def _laws(**laws: object) -> TransmissionVariant:
    return TransmissionVariant(laws=ForceLaws(**laws))  # type: ignore[arg-type]


DEFAULT = "paper_1"
TRANSMISSIONS = {
    DEFAULT: TransmissionVariant(),
    "paper_2": TransmissionVariant(transmission=SecondTransmissionConfig()),
    "spring_quadratic": _laws(spring=SpringConfig("quadratic")),
    "spring_sinh": _laws(spring=SpringConfig("sinh")),
    "damper_linear": _laws(damper=DamperConfig("linear")),
    "damper_quadratic": _laws(damper=DamperConfig("quadratic")),
    "friction_stribeck": _laws(friction=FrictionConfig("stribeck")),
    "friction_lugre": _laws(friction=FrictionConfig("lugre")),
}


@dataclass(frozen=True)
class HealthyCase:
    """Healthy motion of a transmission, with one kind of stamps."""

    transmission: str
    motion: str
    stamps: str
    rate_hz: int

    @property
    def label(self) -> str:
        """Name in lists.

        >>> HealthyCase("paper_1", "steps", "busy", 500).label
        'paper_1 steps, busy stamps, 500 Hz'
        """
        return f"{self.transmission} {self.motion}, {self.stamps} stamps, {self.rate_hz} Hz"


FAULT_CASES = tuple(
    FaultCase(name, duration, motion, rate_hz)
    for name, fault in FAULTS.items()
    for duration, motion, rate_hz in product(fault.durations, fault.motions, RATES_HZ)
)
QUICK_FAULTS = tuple(one for one in FAULT_CASES if one.rate_hz == 100)
# Each combination of transmission, motion and stamps at one of the rates.
HEALTHY_CASES = tuple(
    HealthyCase(transmission, motion, stamps, RATES_HZ[(i + j + k) % len(RATES_HZ)])
    for i, transmission in enumerate(TRANSMISSIONS)
    for j, motion in enumerate(HEALTHY_MOTIONS)
    for k, stamps in enumerate(STAMPS)
)
QUICK_HEALTHY = tuple(
    HealthyCase("paper_1", motion, stamps, 500 if stamps == "busy" else 100)
    for motion in HEALTHY_MOTIONS
    for stamps in ("exact", "busy")
)


def chosen_faults(
    cases: Sequence[FaultCase], names: Sequence[str], motions: Sequence[str], rates_hz: Sequence[int]
) -> Iterator[FaultCase]:
    """Cases whose fault, motion and rate are listed; an empty list permits all."""
    for one in cases:
        if (not names or one.fault in names) and _listed(one.motion, one.rate_hz, motions, rates_hz):
            yield one


def chosen_healthy(
    cases: Sequence[HealthyCase], names: Sequence[str], motions: Sequence[str], rates_hz: Sequence[int]
) -> Iterator[HealthyCase]:
    """Cases whose motion and rate are listed, and transmission or stamps; an empty list permits all."""
    for one in cases:
        listed = not names or HEALTHY in names or {one.transmission, one.stamps} & set(names)
        if listed and _listed(one.motion, one.rate_hz, motions, rates_hz):
            yield one


HEALTHY = "healthy"  # all healthy cases, as a name


def _listed(motion: str, rate_hz: int, motions: Sequence[str], rates_hz: Sequence[int]) -> bool:
    return (not motions or motion in motions) and (not rates_hz or rate_hz in rates_hz)
