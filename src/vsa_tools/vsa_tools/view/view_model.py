# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""View model of the live page of one joint: messages in, frames of curves and a JSON state out."""

from collections.abc import Mapping
from typing import Any

from vsa_common.ros.cdr import Reader
from vsa_tools.topics import TRANSMISSIONS
from vsa_tools.view.events import Events
from vsa_tools.view.joint import JointSection
from vsa_tools.view.time_series import TimeSeriesStore
from vsa_tools.view.transmission import TransmissionSection

DIAGNOSTICS_TIMEOUT_S = 3.0  # [s] without a message until a diagnostic ends: nodes repeat theirs each second
Fields = Mapping[str, str]  # of a message: kind by name


class ViewModel:
    """A joint with its two transmissions.

    The arguments are the fields of TransmissionImpedance, EstimatorState and JointImpedance.
    """

    def __init__(self, impedance: Fields, state: Fields, joint: Fields) -> None:
        self.events = Events()
        self.transmissions = {
            name: TransmissionSection(name, Reader(impedance), Reader(state), self.events) for name in TRANSMISSIONS
        }
        self.joint = JointSection(Reader(joint), self.events)
        self._diagnostics: dict[str, tuple[str, float]] = {}  # text and time [s] of the last message above OK, by node
        streams = {"joint": self.joint.stream}
        for name, section in self.transmissions.items():
            streams |= {name: section.stream, f"{name}/sensor": section.sensor}
        self.series = TimeSeriesStore(streams)

    def add_diagnostics(self, message: Any, time_ns: int, now: float, namespace: str = "") -> None:
        """Add a DiagnosticArray, received at `time_ns` of the wall clock and `now` [s] of a steady clock.

        Nodes outside `namespace` are ignored, and only levels above OK are kept.
        """
        for status in message.status:
            if not status.name.startswith(namespace):
                continue
            name, level = status.name.removeprefix(namespace).lstrip("/"), ord(status.level)
            if level and name not in self._diagnostics:
                self.events.add(time_ns, name, status.message, "warning" if level == 1 else "error")
            elif not level and name in self._diagnostics:
                self.events.add(time_ns, name, "back to OK", "ok")
            self._diagnostics.pop(name, None)
            if level:
                self._diagnostics[name] = status.message, now

    def check_timeouts(self, now: float, wall_ns: int) -> None:
        """Detect timeouts at `now` [s] of a steady clock and `wall_ns` of the wall clock."""
        self.joint.check_timeout(now, wall_ns)
        for section in self.transmissions.values():
            section.check_timeout(now, wall_ns)
        for name, (_, time) in list(self._diagnostics.items()):
            if now - time > DIAGNOSTICS_TIMEOUT_S:
                del self._diagnostics[name]
                self.events.add(wall_ns, name, f"no diagnostics for {DIAGNOSTICS_TIMEOUT_S:g} s", "error")

    def ages(self, now: float) -> dict[str, float]:
        """Time since the last impedance of each source [s]."""
        sections = {"joint": self.joint} | self.transmissions
        return {name: now - section.last_time for name, section in sections.items()}

    def to_json(self, now: float) -> dict[str, Any]:
        """Table, drawing, status and events at `now` [s] of a steady clock."""
        return {
            "joint": self.joint.to_json(now),
            "diagnostics": {name: text for name, (text, _) in self._diagnostics.items()},
            "events": self.events.to_json(),
            **{name: section.to_json(now) for name, section in self.transmissions.items()},
        }
