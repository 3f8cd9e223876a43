"""The live page's state of one transmission: bytes and messages in, curves and words out."""

from typing import Any

from vsa_common.ros.cdr import Reader, read_counters, read_stamp
from vsa_common.types import ResetReason
from vsa_tools.view.events import Events, Tally
from vsa_tools.view.section import Part
from vsa_tools.view.time_series import Stream, lost, quantity

RATE_FILTER = 0.19  # of the force rate, what section VI implies [s]

_SPREAD = ("velocity", "acceleration", "stiffness", "damping", "inertia")
_QUANTITIES = ("force", "deflection", *_SPREAD)
_FIELDS = (*_QUANTITIES, *(f"{name}_variance" for name in _SPREAD), *(f"{name}_valid" for name in _QUANTITIES))
CURVES = ("force_rate", *(name.replace("_variance", "_std") for name in _FIELDS))
_COEFFICIENTS = ("k2", "d1", "d2", "inertia", "force_offset", "coulomb_friction")
_COUNTS = ("samples_fused", "samples_dropped", "force_rejected", "deflection_rejected", "reset_count")
_TOLD = {  # counts of which the page tells when they grow
    "samples_dropped": "sample dropped",
    "force_rejected": "force rejected by the gate",
    "deflection_rejected": "position rejected by the gate",
}
_RESETS = {reason.value: reason.name for reason in ResetReason}


class SideShow(Part):
    """One transmission."""

    def __init__(self, name: str, reader: Reader, state_reader: Reader, events: Events) -> None:
        super().__init__(name, reader, events, _QUANTITIES, _FIELDS)
        self.stream = Stream(CURVES)
        self.sensor = Stream(("position", "residual"))
        self._state_reader = state_reader
        self._tally = Tally(name, events)
        self._state: dict[str, Any] = {}
        self._counters: tuple[int, int] | None = None
        self._smooth: tuple[int, float] = (0, 0.0)

    def take_impedance(self, data: bytes, now: float) -> None:
        """A TransmissionImpedance as it came, `now` on a steady clock [s]."""
        stamp_ns, numbers = self.take(data, now)
        self.stream.add(stamp_ns, (self._force_rate(stamp_ns, numbers[0]), *numbers))

    def take_state(self, data: bytes) -> None:
        """An EstimatorState as it came."""
        stamp_ns, values = self._state_reader.read(data)
        self._state = state = dict(zip(self._state_reader.names, values, strict=True))
        residual = state["deflection_innovation"]
        self.sensor.add(stamp_ns, (state["deflection"] + residual, residual))  # spares the page the encoder's topic
        for name, text in _TOLD.items():
            self._tally.count(text, state[name], stamp_ns)
        self._tally.count("reset", state["reset_count"], stamp_ns, "bad")

    def take_counters(self, data: bytes) -> None:
        """A batch of CaptureCounters as it came."""
        stamp_ns, (_, counters) = read_stamp(data), read_counters(data)
        self._counters = lost(counters, self._counters)
        self._tally.count("sample lost on the bus", self._counters[1], stamp_ns, "bad")

    def words(self, now: float) -> dict[str, Any]:
        """Everything of this side that is not a curve."""
        found = super().words(now)
        if self._state:
            found |= self._state_words(self.fresh(now))
        if self._counters is not None:
            found["lost"] = self._counters[1]
        return found

    def _state_words(self, fresh: bool) -> dict[str, Any]:
        state = self._state
        return {
            "coefficients": {
                name: quantity(*(state[name + end] for end in ("", "_variance", "_valid")), fresh=fresh)
                for name in _COEFFICIENTS
            },
            "reason": state["reason"],
            "observability": state["observability"],
            "reset_reason": _RESETS.get(state["reset_reason"], "UNKNOWN"),
            **{name: state[name] for name in _COUNTS},
        }

    def _force_rate(self, stamp_ns: int, force: float) -> float:
        before, smooth = self._smooth
        dt = 1e-9 * (stamp_ns - before)
        if not 0.0 < dt < 1.0:
            self._smooth = (stamp_ns, force) if before != stamp_ns else self._smooth
            return 0.0
        rate = (force - smooth) / (RATE_FILTER + dt)
        self._smooth = (stamp_ns, smooth + rate * dt)
        return rate
