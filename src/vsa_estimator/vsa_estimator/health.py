"""Complaints about the sensors: stuck, saturated, noisy, or told by the gate too often."""

import math

from vsa_estimator.settings import EstimatorConfig

STUCK_FORCE_TIME = 0.3  # a force that repeats itself for this long while the rod moves is stuck [s]
STUCK_ENCODER_TIME = 0.5  # an encoder that does so while the force changes [s]
QUIET_ENCODER_TIME = 0.15  # an encoder that repeats itself for this long is at rest or stuck [s]
FROZEN_TIME = 0.03  # a flickering encoder that repeats itself for this long, and against all odds, is stuck [s]
ODDS = 25.0  # natural logarithm of those odds
FLICKER = 0.1  # share of samples at which a flickering encoder turns round
DEAFENING = 30.0  # times its usual noise, from which on an encoder is not believed at all
BRISK = (10.0, 3.0)  # slopes of force and deflection after which they ring, in standard deviations a sample
BURST_NS = 50_000_000  # the encoder is not believed for so long after a burst of samples
MEMORY = 500.0  # samples over which flicker is looked for
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
        self._run = 0
        self._repeats = 1.0  # leaky share of samples that repeat the one before
        self._turns = 0.0  # and of those that take the last change back
        self._rose = False

    def observe(self, stamp_ns: int, value: float, other: float) -> None:
        """Take one sample of both."""
        self.repeated = value == self._value
        self._run = self._run + 1 if self.repeated else 0
        self._repeats += (self.repeated - self._repeats) / MEMORY
        turned = False
        if not self.repeated and self._value is not None:
            rose = value > self._value
            turned, self._rose = rose != self._rose, rose
        self._turns += (turned - self._turns) / MEMORY
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

    def frozen(self, stamp_ns: int) -> bool:
        """Whether a value that used to flicker at rest, too, has ceased to."""
        return (
            self._turns > FLICKER
            and self._run * -math.log(min(self._repeats, 0.999)) > ODDS
            and stamp_ns - self.since_ns > FROZEN_TIME * 1e9
        )


class Noisiness:
    """How much louder a sensor's white noise is than it should be, within a few samples.

    Second differences of white noise take each other back, those of a motion do not: their products tell them apart.
    Beyond v* nothing damps a rod: after a brisk motion it rings with its tendon. That is not held against the sensor.
    """

    WORTH = 20.0  # samples
    LOUD = 9.0  # variance, in units of the usual one, that counts as louder
    RINGING = 4.0  # times the steepest slope of late, from sample to sample
    FADED = 0.25  # of the slope from which on a rod may ring, below which it no longer does
    SHARE = 0.35  # of loud samples from which on the noise is

    def __init__(self, brisk: float) -> None:
        """`brisk` is the slope, in standard deviations a sample, from which on a rod may ring."""
        self._brisk = brisk
        self._values = (math.nan, math.nan)
        self._difference = math.nan
        self._slope = 0.0  # a sample, leaky mean
        self._steepest = 0.0  # of late
        self._rings = False
        self._loud = 0.0
        self._variance = 1.0

    def observe(self, value: float, std: float, undamped: bool = False) -> float:
        """Take a sample and the standard deviation that its noise should have; its ratio to that, 1 for the usual.

        `undamped` while the rod is known to move beyond v*.
        """
        before, last = self._values
        difference = value - 2.0 * last + before
        brisk = self._brisk * std
        self._rings = undamped or self._steepest > (self.FADED if self._rings else 1.0) * brisk
        ringing = self.RINGING * max(self._steepest, brisk if undamped else 0.0) if self._rings else 0.0
        product = -difference * self._difference / (4.0 * (std * std + ringing * ringing))
        self._values, self._difference = (last, value), difference
        if product != product:
            return 1.0
        self._slope += (value - last - self._slope) / self.WORTH
        slope, fading = abs(self._slope), self._steepest * (1.0 - 0.05 / self.WORTH)
        self._steepest = slope if slope > fading else fading
        self._loud += ((product > self.LOUD) - self._loud) / self.WORTH
        variance = 0.0 if product < 0.0 else 1e6 if product > 1e6 else product
        self._variance += (variance - self._variance) / self.WORTH
        return math.sqrt(max(self._variance, 1.0)) if self._loud > self.SHARE else 1.0


class Pace:
    """Tells samples that queued up on their way: their stamps are those of a burst, not of the measurement."""

    HURRY = 0.3  # of the usual interval, below which a sample belongs to a burst
    WORTH = 50.0  # samples
    LONGEST = 45e6  # samples of this time may come at once; a busy sender catches up [ns]
    FEWEST = 12

    def __init__(self) -> None:
        """Nothing seen yet."""
        self._last_ns = 0
        self._interval = 0.0  # [ns]
        self._seen = 0
        self._run = 0

    def observe(self, stamp_ns: int) -> bool:
        """Take a stamp; whether it belongs to a burst that is too long."""
        step, self._last_ns = float(stamp_ns - self._last_ns), stamp_ns
        self._seen += 1
        if self._seen < 3:
            self._interval = step
            return False
        self._run = self._run + 1 if step < self.HURRY * self._interval else 0
        worth = min(self._seen, self.WORTH) * (10.0 if self._run else 1.0)
        self._interval += (min(step, 2.0 * self._interval) - self._interval) / worth
        return self._run >= self.FEWEST and self._run * self._interval > self.LONGEST


class Health:
    """Watches every raw sample of both sensors."""

    def __init__(self, config: EstimatorConfig) -> None:
        """Limits and noise from the configuration."""
        self._config = config
        self._force = Constancy()
        self._encoder = Constancy()
        self._complaints: dict[str, int] = {}
        self._pace = Pace()
        self._burst_until_ns = 0
        self.force_repeated = 0
        self.blind = False  # the encoder is not to be believed
        self.undamped = False  # the rod moves beyond v*, as far as the filter knows; whoever has the filter sets it
        self.force_noise = 1.0  # times what it should be
        self.deflection_noise = 1.0
        self._noise = tuple(map(Noisiness, BRISK))
        resolution = config.deflection_resolution / math.sqrt(12.0)
        self._stds = config.force_noise_std, math.hypot(config.deflection_noise_std, resolution)
        friction = config.initial.coulomb_friction + 2.0 * config.initial.coulomb_friction_std
        self._force_travel = 40.0 * config.force_noise_std + 2.0 * friction
        self._deflection_travel = 20.0 * config.deflection_noise_std + 5.0 * config.deflection_resolution

    def clear(self) -> None:
        """Forget the past: stamps went back."""
        self._complaints.clear()
        self.blind = False
        self.force_noise = self.deflection_noise = 1.0
        self._noise = tuple(map(Noisiness, BRISK))
        self._force = Constancy()
        self._encoder = Constancy()
        self._pace = Pace()
        self._burst_until_ns = 0

    def observe(self, stamp_ns: int, force: float, deflection: float) -> bool:
        """Take one raw sample; whether its force is news that may be learnt from."""
        self._force.observe(stamp_ns, force, deflection)
        self._encoder.observe(stamp_ns, deflection, force)
        self._listen(stamp_ns, force, deflection)
        if self._pace.observe(stamp_ns):
            self.complain("samples in a burst: they queued up on their way", stamp_ns)
            self._burst_until_ns = stamp_ns + BURST_NS
        frozen = self._encoder.repeated and self._encoder.frozen(stamp_ns)
        self.blind = frozen or self.deflection_noise > DEAFENING or stamp_ns < self._burst_until_ns
        if frozen:
            self.complain("encoder stuck: it repeats itself to the last digit", stamp_ns)
        fresh = not self._force.repeated
        if not fresh:
            self.force_repeated += 1
            if self._force.stuck(stamp_ns, STUCK_FORCE_TIME, self._deflection_travel):
                self.complain("force sensor stuck: it repeats itself while the encoder moves", stamp_ns)
        if self._encoder.repeated and stamp_ns - self._encoder.since_ns > QUIET_ENCODER_TIME * 1e9:
            fresh = False  # at rest there is nothing to learn, and a stuck encoder must not teach
        if self._encoder.repeated and self._encoder.stuck(stamp_ns, STUCK_ENCODER_TIME, self._force_travel):
            self.complain("encoder stuck: it repeats itself while the force changes", stamp_ns)
            self.blind = True
        if abs(force) >= self._config.force_limit:
            self.complain("force sensor saturated", stamp_ns)
            fresh = False
        if abs(deflection) >= self._config.deflection_limit:
            self.complain("deflection at its limit", stamp_ns)
            fresh = False
            self.blind = True
        return fresh

    def _listen(self, stamp_ns: int, force: float, deflection: float) -> None:
        self.force_noise = self._noise[0].observe(force, self._stds[0], self.undamped)
        self.deflection_noise = self._noise[1].observe(deflection, self._stds[1])
        for sensor, ratio in (("force sensor", self.force_noise), ("encoder", self.deflection_noise)):
            if ratio > 1.0:
                self.complain(f"{sensor} noisy: several times what was configured", stamp_ns)

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
