"""Complaints about the sensors: stuck, saturated, or told by the gate too often."""

from vsa_estimator.settings import EstimatorConfig

STUCK_FORCE_TIME = 0.3  # a force that repeats itself for this long while the rod moves is stuck [s]
STUCK_ENCODER_TIME = 0.5  # an encoder that does so while the force changes [s]
QUIET_ENCODER_TIME = 0.15  # an encoder that repeats itself for this long is at rest or stuck [s]
COMPLAINT_TIME = 0.5  # a complaint stands for this long after its cause [s]


class Constancy:
    """How long a value has repeated itself, and how far another has travelled meanwhile."""

    def __init__(self) -> None:
        """Nothing seen yet."""
        self.repeated = False
        self.since_ns = 0
        self._value: float | None = None
        self._low = 0.0
        self._high = 0.0

    def observe(self, stamp_ns: int, value: float, other: float) -> None:
        """Take one sample of both."""
        self.repeated = value == self._value
        if not self.repeated:
            self._value = value
            self.since_ns = stamp_ns
            self._low = self._high = other
        elif other < self._low:
            self._low = other
        elif other > self._high:
            self._high = other

    def stuck(self, stamp_ns: int, time: float, travel: float) -> bool:
        """Whether the value has stood for `time` [s] while the other one travelled more than `travel`."""
        return stamp_ns - self.since_ns > time * 1e9 and self._high - self._low > travel


class Health:
    """Watches every raw sample of both sensors."""

    def __init__(self, config: EstimatorConfig) -> None:
        """Limits and noise from the configuration."""
        self._config = config
        self._force = Constancy()
        self._encoder = Constancy()
        self._complaints: dict[str, int] = {}
        self.force_repeated = 0
        friction = config.initial.coulomb_friction + 2.0 * config.initial.coulomb_friction_std
        self._force_travel = 40.0 * config.force_noise_std + 2.0 * friction
        self._deflection_travel = 20.0 * config.deflection_noise_std + 5.0 * config.deflection_resolution

    def clear(self) -> None:
        """Forget the past: stamps went back."""
        self._complaints.clear()
        self._force = Constancy()
        self._encoder = Constancy()

    def observe(self, stamp_ns: int, force: float, deflection: float) -> bool:
        """Take one raw sample; whether its force is news that may be learnt from."""
        self._force.observe(stamp_ns, force, deflection)
        self._encoder.observe(stamp_ns, deflection, force)
        fresh = not self._force.repeated
        if not fresh:
            self.force_repeated += 1
            if self._force.stuck(stamp_ns, STUCK_FORCE_TIME, self._deflection_travel):
                self._complain("force sensor stuck: it repeats itself while the encoder moves", stamp_ns)
        if self._encoder.repeated and stamp_ns - self._encoder.since_ns > QUIET_ENCODER_TIME * 1e9:
            fresh = False  # at rest there is nothing to learn, and a stuck encoder must not teach
        if self._encoder.repeated and self._encoder.stuck(stamp_ns, STUCK_ENCODER_TIME, self._force_travel):
            self._complain("encoder stuck: it repeats itself while the force changes", stamp_ns)
        if abs(force) >= self._config.force_limit:
            self._complain("force sensor saturated", stamp_ns)
            fresh = False
        if abs(deflection) >= self._config.deflection_limit:
            self._complain("deflection at its limit", stamp_ns)
            fresh = False
        return fresh

    def _complain(self, text: str, stamp_ns: int) -> None:
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
