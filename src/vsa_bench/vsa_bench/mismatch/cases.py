# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Cases of `./vsa bench mismatch`: one law or one sensor differs from the paper's rig, in five motions at two rates."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

from vsa_common.config.configuration import parameters
from vsa_estimator.settings import EstimatorConfig
from vsa_simulator.laws.config import ForceLaws
from vsa_simulator.laws.dampers import DAMPERS, DamperConfig
from vsa_simulator.laws.friction import FRICTIONS, FrictionConfig
from vsa_simulator.laws.internal import HysteresisConfig, ViscoelasticConfig
from vsa_simulator.laws.springs import EXPONENTIAL, SPRINGS, SpringConfig
from vsa_simulator.rig.config import SensorErrorConfig
from vsa_simulator.rig.motion import Motion, Tone, dwells, tones
from vsa_simulator.rig.recording import TransmissionVariant

RATES_HZ = (100, 1000)
SPRING_GROUP, SENSOR_GROUP, DRAWN_GROUP = "springs", "sensors", "drawn"

MOTIONS = {
    "mix": tones(0.0095, Tone(0.0032, 0.07), Tone(0.00025, 0.6, 1.1), Tone(0.0001, 1.2, 2.2)),
    "sine": tones(0.009, Tone(0.004, 0.05)),
    "dwells": dwells((0.009, 0.013, 0.006, 0.0115, 0.0075, 0.014, 0.005), move=1.5, rest=1.5),
    "fast": tones(0.009, Tone(0.0022, 0.25), Tone(0.0003, 0.9, 1.1), Tone(0.00005, 2.5, 2.2)),
    "narrow": tones(0.011, Tone(0.0016, 0.13), Tone(0.0003, 0.8, 1.1)),
}


def _laws(**laws: object) -> TransmissionVariant:
    return TransmissionVariant(laws=ForceLaws(**laws))  # type: ignore[arg-type]


def _sensors(**errors: float) -> TransmissionVariant:
    return TransmissionVariant(sensor_errors=SensorErrorConfig(**errors))


# spring_exponential is the paper's rig. The other groups change one thing of it.
VARIANTS: dict[str, dict[str, TransmissionVariant]] = {
    SPRING_GROUP: {f"spring_{kind}": _laws(spring=SpringConfig(kind)) for kind in (EXPONENTIAL, *SPRINGS)},
    "dampers": {f"damper_{kind}": _laws(damper=DamperConfig(kind)) for kind in DAMPERS},
    "friction": {
        f"friction_{model}": _laws(friction=FrictionConfig(model))
        for model in FRICTIONS
        if model != FrictionConfig().model
    },
    "time_varying": {
        "viscoelastic": _laws(viscoelastic=ViscoelasticConfig(share=0.2, time_constant=2.0)),
        "scale_drift_1": _laws(spring=SpringConfig(drift=1.0)),
        "scale_drift_10": _laws(spring=SpringConfig(drift=10.0)),
        "bouc_wen": _laws(hysteresis=HysteresisConfig(amplitude=0.6, travel=4e-4, shape=0.5)),
    },
    SENSOR_GROUP: {
        **{f"force_late_{ms}ms": _sensors(force_delay=1e-3 * ms) for ms in (2, 5, 10)},
        "force_lowpass_20hz": _sensors(force_lowpass=20.0),
        **{f"encoder_cyclic_{um}um": _sensors(encoder_cyclic=1e-6 * um) for um in (5, 20)},
        "force_hysteresis": _sensors(force_hysteresis=0.1),
        "force_drift": _sensors(force_drift=0.2),
        "crosstalk": _sensors(crosstalk=0.02),
        "stamp_jitter": TransmissionVariant(stamp_jitter=1e-3),
    },
}
(_LAW,) = (one for one in parameters(EstimatorConfig) if one.name == "elastic_law")
DEFAULT_LAW, LAWS = str(_LAW.default), _LAW.options
GROUP_OF = {name: group for group, variants in VARIANTS.items() for name in variants}


@dataclass(frozen=True)
class Row:
    """One row of the bench."""

    name: str
    motion: str
    rate_hz: int
    elastic_law: str = DEFAULT_LAW

    @property
    def label(self) -> str:
        """Name in lists.

        >>> Case("spring_sinh", "mix", 100).label
        'spring_sinh mix 100 Hz'
        """
        return f"{self.name} {self.motion} {self.rate_hz} Hz"


@dataclass(frozen=True)
class Case(Row):
    """A listed case, by the names of its variant and motion."""

    @property
    def group(self) -> str:
        """Key of VARIANTS."""
        return GROUP_OF[self.name]

    @property
    def variant(self) -> TransmissionVariant:
        """The simulated transmission with its sensors."""
        return VARIANTS[self.group][self.name]

    @property
    def profile(self) -> Motion:
        """The motion."""
        return MOTIONS[self.motion]


ALL = tuple(Case(*one) for one in product(GROUP_OF, MOTIONS, RATES_HZ))
QUICK = (
    Case("spring_exponential", "mix", 100),
    Case("spring_linear", "mix", 100),
    Case("spring_quadratic", "dwells", 100),
    Case("spring_quadratic", "mix", 1000),
    Case("spring_sinh", "sine", 100),
    Case("spring_stop", "narrow", 100),
    Case("damper_soft_knee", "mix", 100),
    Case("friction_stribeck", "fast", 100),
    Case("viscoelastic", "mix", 100),
    Case("scale_drift_10", "narrow", 100),
    Case("force_late_5ms", "mix", 100),
    Case("encoder_cyclic_20um", "dwells", 100),
    Case("crosstalk", "mix", 100),
)


def chosen(
    cases: Sequence[Case], names: Sequence[str], motions: Sequence[str], rates_hz: Sequence[int]
) -> Iterator[Case]:
    """Cases whose name or group, motion and rate are listed; an empty list permits all."""
    for one in cases:
        listed = not names or {one.name, one.group} & set(names)
        if listed and (not motions or one.motion in motions) and (not rates_hz or one.rate_hz in rates_hz):
            yield one
