# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Reader of a report: raw columns of every topic of the suite in a bag, by joint and transmission."""

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
from vsa_tools.report.columns import ColumnBuilder, Series, first_stamp

WRENCH, JOINT_STATE = "geometry_msgs/msg/WrenchStamped", "sensor_msgs/msg/JointState"
IMPEDANCE, STATE = "vsa_msgs/msg/TransmissionImpedance", "vsa_msgs/msg/EstimatorState"
JOINT, COUNTERS = "vsa_msgs/msg/JointImpedance", "vsa_msgs/msg/CaptureCounters"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
ELASTIC_LAW_VALID = "elastic_law_valid"  # flag of the sequences of EstimatorState

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
class Transmission:
    """One transmission; None for a topic that was not recorded."""

    name: str
    force: Series | None = None
    encoder: Series | None = None
    impedance: Series | None = None
    state: Series | None = None
    counters: dict[int, int] = field(default_factory=dict)  # stamp [ns] of a sample -> its counter


@dataclass(frozen=True)
class Joint:
    """One joint; its name is its namespace."""

    name: str
    transmissions: list[Transmission]
    impedance: Series | None = None
    angle: Series | None = None
    torque: Series | None = None


@dataclass(frozen=True)
class Diagnostic:
    """A message above level OK on /diagnostics; messages that differ only in numbers count as one."""

    node: str
    level: int  # 1 warning, 2 error, 3 stale
    text: str  # of the first occurrence
    first: float  # time of the first occurrence [s]
    count: int


@dataclass(frozen=True)
class Run:
    """A recording."""

    path: Path
    start_ns: int
    duration: float  # [s], up to the last sensor sample
    topics: dict[str, Topic]
    joints: list[Joint]
    diagnostics: list[Diagnostic]
    complete: bool  # False for a truncated bag


def read_run(path: Path) -> Run:
    """The readable part of a bag. Raises BagError, on one line, where it has no topic of the suite."""
    found = topics(path)
    matches = {name: match for name, topic in found.items() if (match := _match(topic))}
    if not matches:
        names = ", ".join(f"{topic.name} ({topic.type_name})" for topic in found.values()) or "no topic"
        raise BagError(
            f"{path}: no topic of the suite; expected .../transmission_N/impedance or similar; found {names}"
        )
    builders = _read_columns(path, found, matches)
    samples = [one for one in builders if one.stamps]
    if not samples:
        raise BagError(f"{path}: the topics of the suite have no message")
    start_ns = min((first_stamp(one.stamps) for one in samples if any(one.stamps)), default=0)
    counters, diagnostics = _read_messages(path, found, start_ns)
    series = {one.topic.name: one.series(start_ns) for one in samples}
    return Run(
        path=path,
        start_ns=start_ns,
        duration=_duration(series, matches),
        topics=found,
        joints=_joints(series, matches, counters),
        diagnostics=diagnostics,
        complete=is_complete(path),
    )


def _read_columns(
    path: Path, found: Mapping[str, Topic], matches: Mapping[str, re.Match[str]]
) -> Sequence[ColumnBuilder]:
    """Fields of every topic in `matches`; topics of one kind share the decoder of the one with the most messages."""
    fullest = {matches[name]["leaf"]: name for name in sorted(matches, key=lambda name: found[name].messages)}
    decoders = {leaf: _decoder(path, name, leaf) for leaf, name in fullest.items()}
    builders = {name: _builder(found[name], decoders[match["leaf"]]) for name, match in matches.items()}
    handlers = {name: (builders[name].add, decoders[match["leaf"]].read) for name, match in matches.items()}
    try:
        for name, receive_ns, data in read_raw(path, handlers):
            add, read_one = handlers[name]
            add(receive_ns, *read_one(data))
    except (struct.error, IndexError) as error:
        raise BagError(f"{path}: a message is truncated: {error}") from error
    return list(builders.values())


def _duration(series: dict[str, Series], matches: Mapping[str, Any]) -> float:
    """Time of the last sensor sample [s]; of the last estimate in a bag without sensor samples."""
    sensors = [one for name, one in series.items() if matches[name]["leaf"] in ("force", "encoder")]
    return max(float(np.nanmax(one.time, initial=0.0)) for one in sensors or series.values())


def _match(topic: Topic) -> re.Match[str] | None:
    """Namespace, transmission and kind of a topic by its name; None where the type differs."""
    match = _SIDE.fullmatch(topic.name) or _JOINT.fullmatch(topic.name)
    return match if match and _TYPES[match["leaf"]] == topic.type_name else None


class _Decoder(NamedTuple):
    """Reads stamp [ns] and the fields `names` from the bytes of a message; `sequences` are those of many numbers."""

    names: Sequence[str]
    read: Callable[[bytes], tuple[int, tuple[Any, ...]]]
    sequences: Sequence[str] = ()


def _builder(topic: Topic, decoder: _Decoder) -> ColumnBuilder:
    return ColumnBuilder(topic, decoder.names, decoder.sequences, ELASTIC_LAW_VALID)


def _decoder(path: Path, topic: str, leaf: str) -> _Decoder:
    if leaf not in _SINGLE:
        reader = Reader(fields(path, topic))
        return _Decoder(reader.names, reader.read, reader.sequences)
    name, decode = _SINGLE[leaf]

    def read_one(data: bytes) -> tuple[int, tuple[float, ...]]:
        stamp_ns, value = decode(data)
        return stamp_ns, (value,)

    return _Decoder([name], read_one)


def _read_messages(
    path: Path, found: dict[str, Topic], start_ns: int
) -> tuple[dict[str, dict[str, dict[int, int]]], list[Diagnostic]]:
    """Capture counters by namespace and transmission, and the diagnostics above OK with times after `start_ns`."""
    others = [topic.name for topic in found.values() if topic.type_name in (COUNTERS, DIAGNOSTICS)]
    counters: dict[str, dict[str, dict[int, int]]] = {}
    occurrences: dict[tuple[str, int, str], tuple[int, str, int]] = {}
    for name, receive_ns, message in read(path, others):
        if found[name].type_name == COUNTERS:
            space, _, side = name.removesuffix("/capture_counters").rpartition("/")
            batch = zip(message.stamp, message.counter, strict=False)
            counters.setdefault(space, {}).setdefault(side, {}).update((nanoseconds(s), int(c)) for s, c in batch)
        else:
            stamp_ns = nanoseconds(message.header.stamp) or receive_ns
            for status in message.status:
                key = (status.name, int(status.level), _NUMBER.sub("#", status.message))
                first, text, count = occurrences.get(key, (stamp_ns, status.message, 0))
                occurrences[key] = (first, text, count + 1)
    diagnostics = [
        Diagnostic(node, level, text, max(0.0, (first - start_ns) / NANOSECONDS), count)
        for (node, level, _), (first, text, count) in sorted(occurrences.items(), key=lambda one: one[1])
        if level
    ]
    return counters, diagnostics


def _joints(series: dict[str, Series], matches: Mapping[str, Any], counters: Mapping[str, Any]) -> list[Joint]:
    """One joint for each namespace."""
    transmissions: dict[str, dict[str, dict[str, Series]]] = {}
    of_joint: dict[str, dict[str, Series]] = {}
    for name, one in series.items():
        match = matches[name].groupdict()
        if "side" in match:
            transmissions.setdefault(match["space"], {}).setdefault(match["side"], {})[match["leaf"]] = one
        else:
            of_joint.setdefault(match["space"], {})[match["leaf"]] = one
    return [
        Joint(
            space or "/",
            [
                _transmission(name, topics_of_side, counters.get(space, {}))
                for name, topics_of_side in sorted(transmissions.get(space, {}).items())
            ],
            of_joint.get(space, {}).get("joint_impedance"),
            of_joint.get(space, {}).get("joint_states"),
            of_joint.get(space, {}).get("external_torque"),
        )
        for space in sorted(transmissions.keys() | of_joint.keys())
    ]


def _transmission(name: str, topics_of_side: dict[str, Series], counters: dict[str, dict[int, int]]) -> Transmission:
    return Transmission(
        name,
        force=topics_of_side.get("force"),
        encoder=topics_of_side.get("encoder"),
        impedance=topics_of_side.get("impedance"),
        state=topics_of_side.get("estimator_state"),
        counters=counters.get(name, {}),
    )
