# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""State of the joint on the live page, from serialized messages."""

import math
from typing import Any

from vsa_common.ros.cdr import Reader
from vsa_tools.view.events import Events
from vsa_tools.view.section import Section
from vsa_tools.view.time_series import TIMEOUT_S, Delays, Stream

_QUANTITIES = ("stiffness", "damping", "inertia")
_FIELDS = tuple(name + end for name in _QUANTITIES for end in ("", "_variance", "_valid"))
CURVES = tuple(name.replace("_variance", "_std") for name in _FIELDS)


class JointSection(Section):
    """The joint."""

    def __init__(self, reader: Reader, events: Events) -> None:
        super().__init__("joint", reader, events, _QUANTITIES, _FIELDS)
        self.stream = Stream(CURVES)
        self._delays = Delays()
        self._angle, self._angle_time = 0.0, -math.inf

    def add_impedance(self, data: bytes, received_ns: int, now: float) -> None:
        """Add a serialized JointImpedance, received at `received_ns` and at `now` [s] of a steady clock."""
        stamp_ns, numbers = self.add_impedance_message(data, now)
        self.stream.add(stamp_ns, numbers)
        self._delays.add(received_ns - stamp_ns)

    def set_angle(self, angle: float, now: float) -> None:
        """Angle of the joint [rad] at `now` [s] of a steady clock."""
        self._angle, self._angle_time = angle, now

    def to_json(self, now: float) -> dict[str, Any]:
        """Everything of the joint except its curves."""
        index, values = self.index, self.values
        angle = self._angle if now - self._angle_time <= TIMEOUT_S else None
        state = super().to_json(now) | {"delay": self._delays.to_json(), "angle": angle, "reason": ""}
        if self.is_current(now):
            state["reason"] = values[index["reason"]]
            if values[index["stiffness_range_valid"]]:
                state["range"] = [values[index["stiffness_min"]], values[index["stiffness_max"]]]
        return state
