"""The state behind the live page: bytes and messages in, frames of curves and a table of words out."""

import math
from collections.abc import Mapping
from typing import Any

from vsa_bringup.view_core import Board, Delays, Stream, lost, quantity, status_word
from vsa_bringup.view_wire import Wire
from vsa_estimator.values import Reset

SIDES = ("transmission_1", "transmission_2")
RATE_FILTER = 0.19  # of the force rate, what section VI implies [s]

_SPREAD = ("velocity", "acceleration", "stiffness", "damping", "inertia")
_SIDE = ("force", "force_rate", "deflection", *_SPREAD, *(f"{name}_std" for name in _SPREAD))
_JOINT = ("stiffness", "damping", "inertia")
_COEFFICIENTS = ("k2", "d1", "d2", "inertia", "force_offset", "coulomb_friction")
_COUNTS = ("samples_fused", "samples_dropped", "force_rejected", "deflection_rejected", "reset_count")


class SideShow:
    """One transmission."""

    def __init__(self, wire: Wire) -> None:
        self.stream = Stream(_SIDE)
        self.encoder = Stream(("position",))
        self.residual = Stream(("deflection_innovation",))
        self._wire = wire
        self._at = {name: wire.names.index(name) for name in wire.names}
        self._values: tuple[float, ...] = ()
        self._state: Any = None
        self._seen = -math.inf
        self._counters: tuple[int, int] | None = None
        self._smooth: tuple[int, float] = (0, 0.0)

    def take_impedance(self, data: bytes, now: float) -> int:
        """A TransmissionImpedance as it came, `now` on a steady clock [s]; returns its stamp [ns]."""
        stamp_ns, values = self._wire.read(data)
        self._values, self._seen = values, now
        at = self._at
        force = values[at["force"]]
        numbers = [force, self._force_rate(stamp_ns, force), values[at["deflection"]]]
        numbers += [values[at[name]] for name in _SPREAD]
        numbers += [math.sqrt(max(values[at[name] + 1], 0.0)) for name in _SPREAD]  # the variance follows its value
        self.stream.add(stamp_ns, numbers)
        return stamp_ns

    def take_state(self, message: Any, stamp_ns: int) -> None:
        """An EstimatorState."""
        self._state = message
        self.residual.add(stamp_ns, (message.deflection_innovation,))

    def take_counters(self, message: Any) -> None:
        """A batch of CaptureCounters."""
        self._counters = lost(message.counter, self._counters)

    def words(self, now: float) -> dict[str, Any]:
        """Everything of this side that is not a curve."""
        found: dict[str, Any] = {"status": status_word(self._value("status"), now - self._seen)}
        if self._values:
            found |= {name: self._quantity(name) for name in ("force", "deflection", *_SPREAD)}
        if self._state is not None:
            found |= self._state_words()
        if self._counters is not None:
            found["lost"] = self._counters[1]
        return found

    def _state_words(self) -> dict[str, Any]:
        state = self._state
        resets = {reason.value: reason.name for reason in Reset}
        return {
            "coefficients": {
                name: quantity(
                    getattr(state, name), getattr(state, f"{name}_variance"), getattr(state, f"{name}_valid")
                )
                for name in _COEFFICIENTS
            },
            "reason": state.reason,
            "observability": list(state.observability),
            "reset_reason": resets.get(state.reset_reason, "UNKNOWN"),
            **{name: getattr(state, name) for name in _COUNTS},
        }

    def _quantity(self, name: str) -> dict[str, Any]:
        value, variance, valid = self._values[self._at[name] :][:3]
        return quantity(value, variance, bool(valid))

    def _value(self, name: str) -> float | None:
        return self._values[self._at[name]] if self._values else None

    def _force_rate(self, stamp_ns: int, force: float) -> float:
        before, smooth = self._smooth
        dt = 1e-9 * (stamp_ns - before)
        if not 0.0 < dt < 1.0:
            self._smooth = (stamp_ns, force) if before != stamp_ns else self._smooth
            return 0.0
        rate = (force - smooth) / (RATE_FILTER + dt)
        self._smooth = (stamp_ns, smooth + rate * dt)
        return rate


class JointShow:
    """The joint."""

    def __init__(self, wire: Wire) -> None:
        self.stream = Stream((*_JOINT, *(f"{name}_std" for name in _JOINT), "tension_1", "tension_2"))
        self.delays = Delays()
        self.angle: float | None = None
        self.reason = ""
        self.last = b""  # the newest message as it came, for its text
        self._wire = wire
        self._at = {name: wire.names.index(name) for name in wire.names}
        self._values: tuple[float, ...] = ()
        self._seen = -math.inf

    def take_impedance(self, data: bytes, received_ns: int, now: float) -> None:
        """A JointImpedance as it came, when it was received [ns], `now` on a steady clock [s]."""
        stamp_ns, values = self._wire.read(data)
        self._values, self._seen, self.last = values, now, data
        at = self._at
        numbers = [values[at[name]] for name in _JOINT]
        numbers += [math.sqrt(max(values[at[name] + 1], 0.0)) for name in _JOINT]
        self.stream.add(stamp_ns, (*numbers, values[at["tension_1"]], values[at["tension_2"]]))
        self.delays.add(received_ns - stamp_ns)

    def words(self, now: float) -> dict[str, Any]:
        """Everything of the joint that is not a curve."""
        at, values = self._at, self._values
        found: dict[str, Any] = {
            "status": status_word(values[at["status"]] if values else None, now - self._seen),
            "delay": self.delays.words(),
            "angle": self.angle,
            "reason": self.reason,
        }
        for name in _JOINT:
            if values:
                value, variance, valid = values[at[name] :][:3]
                found[name] = quantity(value, variance, bool(valid))
        return found


class Show:
    """A joint with its two transmissions."""

    def __init__(self, side_fields: Mapping[str, str], joint_fields: Mapping[str, str]) -> None:
        self.sides = {name: SideShow(Wire(side_fields)) for name in SIDES}
        self.joint = JointShow(Wire(joint_fields))
        self.complaints: dict[str, str] = {}
        streams = {"joint": self.joint.stream}
        for name, side in self.sides.items():
            streams |= {name: side.stream, f"{name}/encoder": side.encoder, f"{name}/state": side.residual}
        self.board = Board(streams)

    def take_diagnostics(self, message: Any) -> None:
        """What the nodes say of themselves; only complaints are kept."""
        for status in message.status:
            if ord(status.level):
                self.complaints[status.name] = status.message
            else:
                self.complaints.pop(status.name, None)

    def words(self, now: float) -> dict[str, Any]:
        """The table, the drawing's numbers and the status words at `now` [s] of a steady clock."""
        return {
            "joint": self.joint.words(now),
            "complaints": self.complaints,
            **{name: side.words(now) for name, side in self.sides.items()},
        }
