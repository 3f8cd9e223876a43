# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Reading of rosbag2 recordings: MCAP and SQLite."""

import contextlib
import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.rosbag2 import Reader, ReaderError
from rosbags.serde import SerdeError
from vsa_common.io.bags.definitions import PARSER_ERRORS, BagError, decode, recorded_types
from vsa_common.io.bags.truncated import RawMessage, read_sequentially


@dataclass(frozen=True)
class Topic:
    """One topic of a bag."""

    name: str
    type_name: str
    messages: int


def read(path: str | Path, topics: Collection[str] | None = None) -> Iterator[tuple[str, int, Any]]:
    """Topic, receive time [ns] and message of `topics` (None: all), by receive time.

    `path` is a bag's folder, or one .mcap or .db3 file. Definitions come from the bag itself, else from this suite and
    Jazzy. A truncated MCAP file yields the messages before the damage, in the order of the file.
    Raises BagError where nothing can be read.
    """
    for name, receive_ns, type_name, data, store in _raw(Path(path), topics):
        try:
            yield name, receive_ns, decode(data, type_name, store)[0]
        except (*PARSER_ERRORS, SerdeError) as error:
            raise BagError(f"{path}: {name}: cannot decode {type_name}: {error}") from error


def read_raw(path: str | Path, topics: Collection[str] | None = None) -> Iterator[tuple[str, int, bytes]]:
    """As `read`, with the serialized bytes (CDR) in place of the message."""
    for name, receive_ns, _, data, _ in _raw(Path(path), topics):
        yield name, receive_ns, bytes(data)


def fields(path: str | Path, topic: str) -> dict[str, str]:
    """Fields of a topic's messages as the bag defines them: rosidl type by name; empty for a topic without messages."""
    for _, _, type_name, _, store in _raw(Path(path), [topic]):
        return {name: _rosidl_type(*shape) for name, shape in store.get_msgdef(type_name).fields}
    return {}


def topics(path: str | Path) -> dict[str, Topic]:
    """Topics of a bag by name. Raises BagError where it cannot be read."""
    reader = _open(Path(path))
    if reader is not None:
        with contextlib.closing(reader):
            return {c.topic: Topic(c.topic, c.msgtype, c.msgcount) for c in reader.connections}
    counts: dict[str, Topic] = {}
    for name, _, type_name, _, _ in _raw(Path(path), None):
        counts[name] = Topic(name, type_name, counts[name].messages + 1 if name in counts else 1)
    return counts


def _rosidl_type(node: Nodetype, shape: Any) -> str:
    """A field's type as rosidl writes it: double, uint8[2], sequence<string>, std_msgs/Header."""
    if node in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        element, length = _rosidl_type(*shape[0]), shape[1]
        return f"{element}[{length}]" if node == Nodetype.ARRAY else f"sequence<{element}>"
    name = shape[0] if node == Nodetype.BASE else shape.replace("/msg/", "/")
    return {"float64": "double", "float32": "float", "bool": "boolean"}.get(name, name)


def _raw(path: Path, wanted: Collection[str] | None) -> Iterator[RawMessage]:
    reader = _open(path)
    if reader is None:
        yield from read_sequentially(_files(path, ".mcap"), wanted)
        return
    with contextlib.closing(reader):
        connections = [c for c in reader.connections if wanted is None or c.topic in wanted]
        store = recorded_types(connections)
        if connections:
            for connection, receive_ns, data in reader.messages(connections):
                yield connection.topic, receive_ns, connection.msgtype, data, store


def _open(path: Path) -> Reader | None:
    """An open reader; None for an MCAP recording without an index."""
    if not path.exists():
        raise BagError(f"{path}: no such bag")
    source = path
    if path.is_dir() and not (path / "metadata.yaml").exists():
        if _files(path, ".mcap"):
            return None
        databases = _files(path, ".db3")
        if len(databases) != 1:
            raise BagError(f"{path}: no bag, expected metadata.yaml, a .mcap or a .db3 file")
        source = databases[0]
    try:
        reader = Reader(source)
        reader.open()
        return reader
    except (ReaderError, OSError, *PARSER_ERRORS) as error:
        if _files(path, ".mcap"):
            return None
        raise BagError(f"{path}: {' '.join(str(error).split())}") from error


def _files(path: Path, suffix: str) -> list[Path]:
    """Files of a bag in the order of their numbers: bag_2 before bag_10."""
    return sorted(path.glob(f"*{suffix}"), key=_natural) if path.is_dir() else [path] * (path.suffix == suffix)


def _natural(path: Path) -> list[str | int]:
    """Key for the order of names by the numbers in them; texts and numbers alternate."""
    return [int(part) if i % 2 else part for i, part in enumerate(re.split(r"(\d+)", path.stem))]
