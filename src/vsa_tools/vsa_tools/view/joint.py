"""The live page's state of the joint: bytes in, curves and words out."""

from typing import Any

from vsa_common.ros.cdr import Reader
from vsa_tools.view.events import Events
from vsa_tools.view.section import Part
from vsa_tools.view.time_series import Delays, Stream

_QUANTITIES = ("stiffness", "damping", "inertia")
_FIELDS = tuple(name + end for name in _QUANTITIES for end in ("", "_variance", "_valid"))
CURVES = tuple(name.replace("_variance", "_std") for name in _FIELDS)


class JointShow(Part):
    """The joint."""

    def __init__(self, reader: Reader, events: Events) -> None:
        super().__init__("joint", reader, events, _QUANTITIES, _FIELDS)
        self.stream = Stream(CURVES)
        self.delays = Delays()
        self.angle: float | None = None

    def take_impedance(self, data: bytes, received_ns: int, now: float) -> None:
        """A JointImpedance as it came, when it was received [ns], `now` on a steady clock [s]."""
        stamp_ns, numbers = self.take(data, now)
        self.stream.add(stamp_ns, numbers)
        self.delays.add(received_ns - stamp_ns)

    def words(self, now: float) -> dict[str, Any]:
        """Everything of the joint that is not a curve."""
        at, values = self.at, self.values
        found = super().words(now) | {"delay": self.delays.words(), "angle": self.angle, "reason": ""}
        if values:
            found["reason"] = values[at["reason"]]
            if values[at["stiffness_range_valid"]]:
                found["range"] = [values[at["stiffness_min"]], values[at["stiffness_max"]]]
        return found
