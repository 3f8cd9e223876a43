# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The suite's topics of one recorded run as arrays: the one reader for summary.json and the scenarios."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from vsa_common.io.bags import read
from vsa_common.stamps import nanoseconds
from vsa_common.types import Status
from vsa_tools.topics import TRANSMISSIONS

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

JOINT = "joint"
SOURCES = (*TRANSMISSIONS, JOINT)  # of impedance estimates
NO_SAMPLE = -1  # sample number of a stamp that no frame carries


@dataclass(frozen=True)
class Frames:
    """Sample number of the rig (`counter`) for each capture stamp; the stamps ascend."""

    stamp_ns: Integers
    counter: Integers

    def samples(self, stamp_ns: Integers) -> Integers:
        """Sample numbers of `stamp_ns`; NO_SAMPLE where no frame carries the stamp."""
        if not len(self.stamp_ns):
            return np.full(len(stamp_ns), NO_SAMPLE)
        index = np.clip(np.searchsorted(self.stamp_ns, stamp_ns), 0, len(self.stamp_ns) - 1)
        return np.where(self.stamp_ns[index] == stamp_ns, self.counter[index], NO_SAMPLE)


@dataclass(frozen=True)
class Diagnostic:
    """One text of /diagnostics or one `reason` of an estimator, as "source: text", with its own stamp."""

    stamp_ns: int
    text: str


class Command(NamedTuple):
    """A commanded stiffness [N m/rad]."""

    stamp_ns: int
    stiffness: float


class ControlState(NamedTuple):
    """Operating mode of the stiffness controller in its diagnostics, with its reason."""

    stamp_ns: int
    mode: str
    reason: str


class Estimate(NamedTuple):
    """Fields of one impedance message of a transmission or of the joint; SI."""

    stamp_ns: int
    stiffness: float
    stiffness_variance: float
    damping: float
    damping_variance: float
    stiffness_valid: bool
    status_valid: bool  # status VALID


class RecordedRun:
    """The topics of one namespace of a bag. Raises BagError where it cannot be read."""

    def __init__(self, bag: Path, namespace: str = "/vsa") -> None:
        self.diagnostics: list[Diagnostic] = []  # without those of the simulated rig, which name the injected fault
        self.commands: list[Command] = []
        self.control: list[ControlState] = []  # each change of mode
        self._controller = f"{namespace}/stiffness_controller"
        self.last_state: dict[str, Any] = {}  # EstimatorState by transmission
        self._estimates: dict[str, list[Estimate]] = {source: [] for source in SOURCES}
        self._transmission_stamps: list[list[int]] = []
        self._frames: dict[str, list[tuple[int, int]]] = {side: [] for side in TRANSMISSIONS}
        handlers = self._handlers(namespace)
        for topic, _, message in read(bag, list(handlers)):
            handlers[topic](message)

    def frames(self, *sides: str) -> Frames:
        """Capture stamps of `sides` together, in ascending order."""
        rows = [row for side in sides for row in self._frames[side]]
        stamps, counters = np.array(rows, dtype=np.int64).reshape(-1, 2).T
        order = np.lexsort((counters, stamps))
        return Frames(stamps[order], counters[order])

    def estimates(self, source: str) -> dict[str, NDArray[Any]]:
        """Columns of the impedance messages of `source`, by the names of Estimate, in the order of the bag."""
        columns = list(zip(*self._estimates[source], strict=True)) or [()] * len(Estimate._fields)
        types = dict.fromkeys(Estimate._fields, float) | {"stamp_ns": np.int64}
        return {
            name: np.array(column, dtype=types[name]) for name, column in zip(Estimate._fields, columns, strict=True)
        }

    def transmission_stamps(self) -> Integers:
        """Stamps [ns] of both transmissions in each joint message, shape (n, 2)."""
        return np.array(self._transmission_stamps, dtype=np.int64).reshape(-1, 2)

    def _handlers(self, namespace: str) -> dict[str, Callable[[Any], None]]:
        handlers: dict[str, Callable[[Any], None]] = {
            f"{namespace}/joint_impedance": self._add_joint,
            f"{namespace}/stiffness_command": self._add_command,
            "/diagnostics": self._add_diagnostics,
        }
        for side in TRANSMISSIONS:
            handlers[f"{namespace}/{side}/capture_counters"] = partial(self._add_frames, side)
            handlers[f"{namespace}/{side}/impedance"] = partial(self._add_estimate, side)
            handlers[f"{namespace}/{side}/estimator_state"] = partial(self._add_state, side)
        return handlers

    def _add_frames(self, side: str, message: Any) -> None:
        stamps = (nanoseconds(stamp) for stamp in message.stamp)
        self._frames[side] += zip(stamps, map(int, message.counter), strict=True)

    def _add_estimate(self, source: str, message: Any) -> None:
        self._estimates[source].append(
            Estimate(
                nanoseconds(message.header.stamp),
                message.stiffness,
                message.stiffness_variance,
                message.damping,
                message.damping_variance,
                message.stiffness_valid,
                message.status == Status.VALID,
            )
        )

    def _add_joint(self, message: Any) -> None:
        self._add_estimate(JOINT, message)
        self._transmission_stamps.append([nanoseconds(stamp) for stamp in message.transmission_stamp])

    def _add_state(self, side: str, message: Any) -> None:
        self.last_state[side] = message
        self.diagnostics.append(Diagnostic(nanoseconds(message.header.stamp), f"{side}: {message.reason}"))

    def _add_diagnostics(self, message: Any) -> None:
        stamp_ns = nanoseconds(message.header.stamp)
        self.diagnostics += [
            Diagnostic(stamp_ns, f"{status.name}: {status.message}")
            for status in message.status
            if "rig_simulator" not in status.name
        ]

        for status in message.status:
            if status.name.startswith(self._controller):
                values = {value.key: value.value for value in status.values}
                self._add_mode(ControlState(stamp_ns, values.get("mode", ""), values.get("reason", status.message)))

    def _add_mode(self, state: ControlState) -> None:
        if state.mode and (not self.control or self.control[-1].mode != state.mode):
            self.control.append(state)

    def _add_command(self, message: Any) -> None:
        self.commands.append(Command(nanoseconds(message.header.stamp), message.stiffness))
