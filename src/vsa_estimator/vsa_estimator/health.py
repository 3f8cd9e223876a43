"""Complaints about the sensors: stuck, saturated, noisy, or told by the gate too often."""

import math

import numpy as np
from vsa_estimator import signs
from vsa_estimator.settings import EstimatorConfig

BRISK = (10.0, 3.0)  # slopes of force and deflection after which they ring, in standard deviations a sample
BURST_NS = 50_000_000  # the encoder is not believed for so long after a burst of samples
COMPLAINT_TIME = 0.5  # a complaint stands for this long after its cause [s]

COMPLAINTS = {
    signs.FORCE_NOISY: "force sensor noisy: several times what was configured",
    signs.ENCODER_NOISY: "encoder noisy: several times what was configured",
    signs.BURST: "samples in a burst: they queued up on their way",
    signs.ENCODER_FROZEN: "encoder stuck: it repeats itself to the last digit",
    signs.FORCE_STUCK: "force sensor stuck: it repeats itself while the encoder moves",
    signs.ENCODER_STUCK: "encoder stuck: it repeats itself while the force changes",
    signs.FORCE_SATURATED: "force sensor saturated",
    signs.DEFLECTION_SATURATED: "deflection at its limit",
}
BLINDING = signs.ENCODER_FROZEN | signs.ENCODER_STUCK | signs.DEFLECTION_SATURATED | signs.DEAFENING
NO_LESSON = (  # at rest there is nothing to learn, and a stuck encoder must not teach
    signs.FORCE_REPEATED | signs.ENCODER_QUIET | signs.FORCE_SATURATED | signs.DEFLECTION_SATURATED
)


class Health:
    """Watches every raw sample of both sensors."""

    def __init__(self, config: EstimatorConfig) -> None:
        """Limits and noise from the configuration."""
        self.force_repeated = 0
        self.undamped = False  # the rod moves beyond v*, as far as the filter knows; whoever has the filter sets it
        resolution = config.deflection_resolution / math.sqrt(12.0)
        force_std, deflection_std = config.force_noise_std, math.hypot(config.deflection_noise_std, resolution)
        friction = config.initial.coulomb_friction + 2.0 * config.initial.coulomb_friction_std
        self._limits = limits = np.zeros(signs.LIMITS)
        limits[signs.FORCE_STD], limits[signs.DEFLECTION_STD] = force_std, deflection_std
        limits[signs.BRISK_FORCE], limits[signs.BRISK_DEFLECTION] = BRISK[0] * force_std, BRISK[1] * deflection_std
        limits[signs.FORCE_TRAVEL] = 40.0 * config.force_noise_std + 2.0 * friction
        limits[signs.DEFLECTION_TRAVEL] = 20.0 * config.deflection_noise_std + 5.0 * config.deflection_resolution
        limits[signs.FORCE_LIMIT], limits[signs.DEFLECTION_LIMIT] = config.force_limit, config.deflection_limit
        self.clear()

    def clear(self) -> None:
        """Forget the past: stamps went back."""
        self._complaints: dict[str, int] = {}
        self.blind = False  # the encoder is not to be believed
        self._memory = signs.nothing_seen()
        self._burst_until_ns = 0

    def observe(self, stamp_ns: int, force: float, deflection: float) -> bool:
        """Take one raw sample; whether its force is news that may be learnt from."""
        found = signs.examine(self._memory, self._limits, stamp_ns, force, deflection, self.undamped)
        if found & signs.BURST:
            self._burst_until_ns = stamp_ns + BURST_NS
        self.blind = found & BLINDING > 0 or stamp_ns < self._burst_until_ns
        if not found:
            return True
        self.force_repeated += found & signs.FORCE_REPEATED
        for sign, complaint in COMPLAINTS.items():
            if found & sign:
                self.complain(complaint, stamp_ns)
        return not found & NO_LESSON

    @property
    def force_noise(self) -> float:
        """Noise of the force, times what it should be."""
        return float(self._memory[-2])

    @property
    def deflection_noise(self) -> float:
        """Noise of the encoder, times what it should be."""
        return float(self._memory[-1])

    def complain(self, text: str, stamp_ns: int) -> None:
        """Say `text` from now on for a while."""
        self._complaints[text] = stamp_ns + int(COMPLAINT_TIME * 1e9)

    def complaints(self, stamp_ns: int) -> list[str]:
        """Complaints that stand at an instant."""
        if not self._complaints:
            return []
        return [text for text, until_ns in self._complaints.items() if stamp_ns < until_ns]


class SpikeGate:
    """Singles out samples that leave the line of their two predecessors; for streams much faster than the motion."""

    def __init__(self, std: float) -> None:
        """`std` of the white noise; ten times that of a second difference is a spike."""
        self._limit = 10.0 * 6.0**0.5 * std
        self._last: tuple[float, float] | None = None
        self._run = 0

    def passes(self, value: float) -> bool:
        """Whether to believe a sample; the third in a row that is off is believed: the signal itself has jumped."""
        last = self._last
        if last is not None and self._run < 2 and abs(value - 2.0 * last[1] + last[0]) > self._limit:
            self._run += 1
            return False
        self._last = (value, value) if last is None or self._run else (last[1], value)
        self._run = 0
        return True
