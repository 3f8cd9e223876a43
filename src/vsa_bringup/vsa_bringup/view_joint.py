"""The live page's state of the joint: bytes in, curves and words out."""

import math
from operator import itemgetter
from typing import Any

from vsa_bringup.view_core import SILENT, Delays, Stream, quantity, status_word
from vsa_bringup.view_events import Events, Turns
from vsa_bringup.wire import Wire

_QUANTITIES = ("stiffness", "damping", "inertia")
_FIELDS = tuple(name + end for name in _QUANTITIES for end in ("", "_variance", "_valid"))
CURVES = tuple(name.replace("_variance", "_std") for name in _FIELDS)


class JointShow:
    """The joint."""

    def __init__(self, wire: Wire, events: Events) -> None:
        self.stream = Stream(CURVES)
        self.delays = Delays()
        self.angle: float | None = None
        self.seen = -math.inf
        self._wire = wire
        self._at = {name: wire.names.index(name) for name in wire.names}
        self._values: tuple[Any, ...] = ()
        self._stamp_ns = 0
        self._status: float | None = None
        self._turns = Turns("joint", events)
        self._pick = itemgetter(*(self._at[name] for name in _FIELDS))
        self._status_at = self._at["status"]

    def take_impedance(self, data: bytes, received_ns: int, now: float) -> None:
        """A JointImpedance as it came, when it was received [ns], `now` on a steady clock [s]."""
        stamp_ns, values = self._wire.read(data)
        self._values, self.seen, self._stamp_ns = values, now, stamp_ns
        status = values[self._status_at]
        if status != self._status:
            self._status = status
            self._turns.turn(status_word(status, 0.0), stamp_ns)
        self.stream.add(stamp_ns, self._pick(values))
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
            "reason": values[at["reason"]] if values else "",
        }
        if not values:
            return found
        found["stamp_ns"] = str(self._stamp_ns)
        if values[at["stiffness_range_valid"]]:
            found["range"] = [values[at["stiffness_min"]], values[at["stiffness_max"]]]
        for name in _QUANTITIES:
            found[name] = quantity(*values[at[name] :][:3], fresh=now - self.seen <= SILENT)
        return found
