"""The state behind the live page of one joint: bytes and messages in, frames of curves and a table of words out."""

from collections.abc import Mapping
from typing import Any

from vsa_common.ros.cdr import Reader
from vsa_tools.topics import TRANSMISSIONS
from vsa_tools.view.events import Events
from vsa_tools.view.joint import JointShow
from vsa_tools.view.time_series import Board
from vsa_tools.view.transmission import SideShow

Fields = Mapping[str, str]  # of a message: kind by name


class Show:
    """A joint with its two transmissions, from TransmissionImpedance, EstimatorState and JointImpedance."""

    def __init__(self, of_side: Fields, of_state: Fields, of_joint: Fields) -> None:
        self.events = Events()
        self.sides = {name: SideShow(name, Reader(of_side), Reader(of_state), self.events) for name in TRANSMISSIONS}
        self.joint = JointShow(Reader(of_joint), self.events)
        self._complaints: dict[str, str] = {}
        streams = {"joint": self.joint.stream}
        for name, side in self.sides.items():
            streams |= {name: side.stream, f"{name}/sensor": side.sensor}
        self.board = Board(streams)

    def take_diagnostics(self, message: Any, time_ns: int, space: str = "") -> None:
        """What the nodes below namespace `space` say of themselves; only complaints are kept."""
        for status in message.status:
            if not status.name.startswith(space):
                continue
            name, level = status.name.removeprefix(space).lstrip("/"), ord(status.level)
            if level and name not in self._complaints:
                self.events.add(time_ns, name, status.message, "warn" if level == 1 else "bad")
            elif not level and name in self._complaints:
                self.events.add(time_ns, name, "well again", "good")
            self._complaints.pop(name, None)
            if level:
                self._complaints[name] = status.message

    def watch(self, now: float, wall_ns: int) -> None:
        """Notice what makes no message: silence, at `now` [s] of a steady clock and `wall_ns` of the day's."""
        self.joint.watch(now, wall_ns)
        for side in self.sides.values():
            side.watch(now, wall_ns)

    def ages(self, now: float) -> dict[str, float]:
        """Time since the last impedance of each part [s]."""
        return {"joint": now - self.joint.seen} | {name: now - side.seen for name, side in self.sides.items()}

    def words(self, now: float) -> dict[str, Any]:
        """The table, the drawing's numbers, the status words and the events at `now` [s] of a steady clock."""
        return {
            "joint": self.joint.words(now),
            "complaints": self._complaints,
            "events": self.events.words(),
            **{name: side.words(now) for name, side in self.sides.items()},
        }
