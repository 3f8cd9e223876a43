"""The live page's state of the joint: bytes in, curves and words out."""

import math
from typing import Any

from vsa_bringup.view_core import SILENT, Delays, Stream, quantity, status_word
from vsa_bringup.view_events import Events, Turns
from vsa_bringup.view_wire import Wire

_QUANTITIES = ("stiffness", "damping", "inertia")
CURVES = (*_QUANTITIES, *(f"{name}_std" for name in _QUANTITIES), *(f"{name}_valid" for name in _QUANTITIES))


class JointShow:
    """The joint."""

    def __init__(self, wire: Wire, events: Events) -> None:
        self.stream = Stream(CURVES)
        self.delays = Delays()
        self.angle: float | None = None
        self.reason = ""
        self.last = b""  # the newest message as it came, for its text
        self.seen = -math.inf
        self._wire = wire
        self._at = {name: wire.names.index(name) for name in wire.names}
        self._values: tuple[float, ...] = ()
        self._stamp_ns = 0
        self._status: float | None = None
        self._turns = Turns("joint", events)

    def take_impedance(self, data: bytes, received_ns: int, now: float) -> None:
        """A JointImpedance as it came, when it was received [ns], `now` on a steady clock [s]."""
        stamp_ns, values = self._wire.read(data)
        self._values, self.seen, self._stamp_ns, self.last = values, now, stamp_ns, data
        at = self._at
        status = values[at["status"]]
        if status != self._status:
            self._status = status
            self._turns.turn(status_word(status, 0.0), stamp_ns)
        numbers = [values[at[name]] for name in _QUANTITIES]
        numbers += [math.sqrt(max(values[at[name] + 1], 0.0)) for name in _QUANTITIES]  # variance and validity follow
        numbers += [values[at[name] + 2] for name in _QUANTITIES]
        self.stream.add(stamp_ns, numbers)
        self.delays.add(received_ns - stamp_ns)

    def watch(self, now: float, wall_ns: int) -> None:
        """Notice silence."""
        if self._values and now - self.seen > SILENT:
            self._status = None
            self._turns.turn("SILENT", wall_ns)

    def words(self, now: float) -> dict[str, Any]:
        """Everything of the joint that is not a curve."""
        at, values = self._at, self._values
        found: dict[str, Any] = {
            "status": status_word(values[at["status"]] if values else None, now - self.seen),
            "delay": self.delays.words(),
            "angle": self.angle,
            "reason": self.reason,
        }
        if not values:
            return found
        found["stamp_ns"] = str(self._stamp_ns)
        if values[at["stiffness_range_valid"]]:
            found["range"] = [values[at["stiffness_min"]], values[at["stiffness_max"]]]
        for name in _QUANTITIES:
            found[name] = quantity(*values[at[name] :][:3], fresh=now - self.seen <= SILENT)
        return found
