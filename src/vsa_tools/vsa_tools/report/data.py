"""What a report needs of a bag."""

import re
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from vsa_common.io.bags import BagError, Topic, fields, read, read_raw, topics
from vsa_common.ros.cdr import TORQUE_Z, Reader, read_position, read_wrench
from vsa_common.stamps import NANOSECONDS, nanoseconds
from vsa_estimator.offline.recordings import is_complete
from vsa_tools.report.columns import Gatherer, Series, first_stamp

WRENCH, JOINT_STATE = "geometry_msgs/msg/WrenchStamped", "sensor_msgs/msg/JointState"
IMPEDANCE, STATE = "vsa_msgs/msg/TransmissionImpedance", "vsa_msgs/msg/EstimatorState"
JOINT, COUNTERS = "vsa_msgs/msg/JointImpedance", "vsa_msgs/msg/CaptureCounters"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"

_SIDE = re.compile(r"(?P<space>.*)/(?P<side>transmission_\w+)/(?P<leaf>force|encoder|impedance|estimator_state)")
_JOINT = re.compile(r"(?P<space>.*)/(?P<leaf>joint_impedance|joint_states|external_torque)")
_NUMBER = re.compile(r"\d+(\.\d+)?")
_TYPES = {
    "force": WRENCH, "encoder": JOINT_STATE, "impedance": IMPEDANCE, "estimator_state": STATE,
    "joint_impedance": JOINT, "joint_states": JOINT_STATE, "external_torque": WRENCH,
}  # fmt: skip
_SINGLE: dict[str, tuple[str, Callable[[bytes], tuple[int, float]]]] = {  # topics of one number
    "force": ("force", read_wrench), "encoder": ("position", read_position),
    "joint_states": ("position", read_position), "external_torque": ("torque", partial(read_wrench, which=TORQUE_Z)),
}  # fmt: skip


@dataclass(frozen=True)
class Side:
    """One transmission; None for what was not recorded."""

    name: str
    force: Series | None = None
    encoder: Series | None = None
    impedance: Series | None = None
    state: Series | None = None
    counters: dict[int, int] = field(default_factory=dict)  # stamp [ns] of a sample -> its counter


@dataclass(frozen=True)
class Joint:
    """One joint, by its namespace."""

    name: str
    sides: list[Side]
    impedance: Series | None = None
    angle: Series | None = None
    torque: Series | None = None


@dataclass(frozen=True)
class Complaint:
    """Something that a node said of itself on /diagnostics, numbers apart."""

    node: str
    level: int  # 1 warning, 2 error, 3 stale
    text: str  # as it was said first
    first: float  # when it was first said [s]
    count: int


@dataclass(frozen=True)
class Run:
    """A whole recording."""

    path: Path
    start_ns: int
    duration: float  # [s], up to the last sensor sample
    topics: dict[str, Topic]
    joints: list[Joint]
    complaints: list[Complaint]
    complete: bool  # False for a bag that was cut off


def read_run(path: Path) -> Run:
    """The readable part of a bag. Raises BagError with one line where it holds nothing of the suite's."""
    found = topics(path)
    ours = {name: match for name, topic in found.items() if (match := _match(topic))}
    if not ours:
        held = ", ".join(f"{topic.name} ({topic.type_name})" for topic in found.values()) or "no topic at all"
        raise BagError(
            f"{path}: none of the suite's topics, expected .../transmission_N/impedance or such; found {held}"
        )
    fullest = {ours[name]["leaf"]: name for name in sorted(ours, key=lambda name: found[name].messages)}
    decoders = {leaf: _decoder(path, name, leaf) for leaf, name in fullest.items()}
    gathered = {name: Gatherer(found[name], decoders[match["leaf"]].names) for name, match in ours.items()}
    takers = {name: (gathered[name].take, decoders[match["leaf"]].read) for name, match in ours.items()}
    try:
        for name, receive_ns, data in read_raw(path, takers):
            take, read_one = takers[name]
            take(receive_ns, *read_one(data))
    except (struct.error, IndexError) as error:
        raise BagError(f"{path}: a message ends too early: {error}") from error
    counters, complaints = _gather_messages(path, found)
    samples = [one for one in gathered.values() if one.stamps]
    if not samples:
        raise BagError(f"{path}: the suite's topics are there, but not one message")
    start_ns = min(first_stamp(one.stamps) for one in samples)
    series = {one.topic.name: one.series(start_ns) for one in samples}
    return Run(
        path=path,
        start_ns=start_ns,
        duration=_duration(series, ours),
        topics=found,
        joints=_joints(series, ours, counters),
        complaints=complaints,
        complete=is_complete(path),
    )


def _duration(series: dict[str, Series], matches: Mapping[str, Any]) -> float:
    """When the last sensor sample came [s]; what estimators predict into the silence after it counts where none did."""
    sensors = [one for name, one in series.items() if matches[name]["leaf"] in ("force", "encoder")]
    return max(float(np.nanmax(one.time, initial=0.0)) for one in sensors or series.values())


def _match(topic: Topic) -> re.Match[str] | None:
    """How a topic's name says what it is, if its type agrees."""
    match = _SIDE.fullmatch(topic.name) or _JOINT.fullmatch(topic.name)
    return match if match and _TYPES[match["leaf"]] == topic.type_name else None


class _Decoder(NamedTuple):
    """Stamp [ns] and the fields `names` of a topic's messages, straight from the bytes."""

    names: Sequence[str]
    read: Callable[[bytes], tuple[int, tuple[Any, ...]]]


def _decoder(path: Path, topic: str, leaf: str) -> _Decoder:
    if leaf not in _SINGLE:
        reader = Reader(fields(path, topic))
        return _Decoder(reader.names, reader.read)
    name, decode = _SINGLE[leaf]

    def read_one(data: bytes) -> tuple[int, tuple[float, ...]]:
        stamp_ns, value = decode(data)
        return stamp_ns, (value,)

    return _Decoder([name], read_one)


def _gather_messages(
    path: Path, found: dict[str, Topic]
) -> tuple[dict[str, dict[str, dict[int, int]]], list[Complaint]]:
    """Everything else: counters by namespace and transmission, and what /diagnostics said."""
    others = [topic.name for topic in found.values() if topic.type_name in (COUNTERS, DIAGNOSTICS)]
    counters: dict[str, dict[str, dict[int, int]]] = {}
    said: dict[tuple[str, int, str], tuple[int, str, int]] = {}
    start_ns = 0
    for name, receive_ns, message in read(path, others):
        start_ns = start_ns or receive_ns
        if found[name].type_name == COUNTERS:
            space, _, side = name.removesuffix("/capture_counters").rpartition("/")
            batch = zip(message.stamp, message.counter, strict=False)
            counters.setdefault(space, {}).setdefault(side, {}).update((nanoseconds(s), int(c)) for s, c in batch)
        else:
            for status in message.status:
                key = (status.name, int(status.level), _NUMBER.sub("#", status.message))
                first, text, count = said.get(key, (receive_ns, status.message, 0))
                said[key] = (first, text, count + 1)
    complaints = [
        Complaint(node, level, text, max(0.0, (first - start_ns) / NANOSECONDS), count)
        for (node, level, _), (first, text, count) in sorted(said.items(), key=lambda one: one[1])
        if level
    ]
    return counters, complaints


def _joints(series: dict[str, Series], matches: Mapping[str, Any], counters: Mapping[str, Any]) -> list[Joint]:
    """Each namespace a joint."""
    sides: dict[str, dict[str, dict[str, Series]]] = {}
    whole: dict[str, dict[str, Series]] = {}
    for name, one in series.items():
        match = matches[name].groupdict()
        if "side" in match:
            sides.setdefault(match["space"], {}).setdefault(match["side"], {})[match["leaf"]] = one
        else:
            whole.setdefault(match["space"], {})[match["leaf"]] = one
    return [
        Joint(
            space or "/",
            [_side(name, parts, counters.get(space, {})) for name, parts in sorted(sides.get(space, {}).items())],
            whole.get(space, {}).get("joint_impedance"),
            whole.get(space, {}).get("joint_states"),
            whole.get(space, {}).get("external_torque"),
        )
        for space in sorted(sides.keys() | whole.keys())
    ]


def _side(name: str, parts: dict[str, Series], counters: dict[str, dict[int, int]]) -> Side:
    return Side(
        name,
        force=parts.get("force"),
        encoder=parts.get("encoder"),
        impedance=parts.get("impedance"),
        state=parts.get("estimator_state"),
        counters=counters.get(name, {}),
    )
