"""The one door to rosbags and mcap: read and write rosbag2 recordings without ROS.

>>> for topic, receive_ns, message in read("demo/bag", ["/vsa/joint_impedance"]):
...     print(message.stiffness)
"""

import contextlib
import struct
import threading
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from ament_index_python.packages import PackageNotFoundError, get_package_share_directory
from mcap.exceptions import McapError
from mcap.records import Channel, Message, Schema
from mcap.stream_reader import StreamReader
from rosbags.interfaces import (
    Connection,
    MessageDefinitionFormat,
    Nodetype,
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import Reader, ReaderError, StoragePlugin, Writer, WriterError
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, TypesysError, get_types_from_idl, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

_OWN_PACKAGE = "vsa_msgs"
# What the parsers of both libraries let through when a file ends in the middle of a record.
_DAMAGE = (McapError, struct.error, EOFError, TypeError, ValueError, LookupError, OverflowError, MemoryError)
_LISTS_LAST = ("sensor_msgs/msg/JointState",)  # of these Fast DDS hands out more bytes than there are
_FOREVER = QosTime(9223372036, 854775807)
_RELIABLE = Qos(
    QosHistory.KEEP_LAST, 1000, QosReliability.RELIABLE, QosDurability.VOLATILE,
    _FOREVER, _FOREVER, QosLiveliness.AUTOMATIC, _FOREVER, False,
)  # fmt: skip


class BagError(ValueError):
    """A bag cannot be read or written; the text names the file and the reason."""


@dataclass(frozen=True)
class Topic:
    """One topic of a bag."""

    name: str
    type_name: str
    messages: int


def read(path: str | Path, topics: Collection[str] | None = None) -> Iterator[tuple[str, int, Any]]:
    """Topic, receive time [ns] and message of `topics` (None: all), by receive time.

    Takes a bag's folder, or one .mcap or .db3 file. Definitions come from the bag itself, else from this suite and
    Jazzy. An MCAP file that was cut off yields what it holds up to there, in the order of the file.
    Raises BagError where nothing can be read.
    """
    for name, receive_ns, type_name, data, store in _raw(Path(path), topics):
        try:
            yield name, receive_ns, _decode(data, type_name, store)[0]
        except (*_DAMAGE, SerdeError) as error:
            raise BagError(f"{path}: {name}: cannot decode {type_name}: {error}") from error


def read_raw(path: str | Path, topics: Collection[str] | None = None) -> Iterator[tuple[str, int, bytes]]:
    """As `read`, with the serialized bytes (CDR) in place of the message."""
    for name, receive_ns, _, data, _ in _raw(Path(path), topics):
        yield name, receive_ns, bytes(data)


def fields(path: str | Path, topic: str) -> dict[str, str]:
    """Fields of a topic's messages as the bag defines them: kind by name, in rosidl's words; none without a message."""
    for _, _, type_name, _, store in _raw(Path(path), [topic]):
        return {name: _kind(*shape) for name, shape in store.get_msgdef(type_name).fields}
    return {}


def _kind(node: Nodetype, shape: Any) -> str:
    """A field's type in the words of rosidl: double, uint8[2], sequence<string>, std_msgs/Header."""
    if node in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        element, length = _kind(*shape[0]), shape[1]
        return f"{element}[{length}]" if node == Nodetype.ARRAY else f"sequence<{element}>"
    name = shape[0] if node == Nodetype.BASE else shape.replace("/msg/", "/")
    return {"float64": "double", "float32": "float", "bool": "boolean"}.get(name, name)


def topics(path: str | Path) -> dict[str, Topic]:
    """What a bag holds. Raises BagError where it cannot be read."""
    reader = _open(Path(path))
    if reader is not None:
        with contextlib.closing(reader):
            return {c.topic: Topic(c.topic, c.msgtype, c.msgcount) for c in reader.connections}
    counts: dict[str, Topic] = {}
    for name, _, type_name, _, _ in _raw(Path(path), None):
        counts[name] = Topic(name, type_name, counts[name].messages + 1 if name in counts else 1)
    return counts


_Raw = tuple[str, int, str, bytes, Typestore]


def _raw(path: Path, wanted: Collection[str] | None) -> Iterator[_Raw]:
    reader = _open(path)
    if reader is None:
        yield from _salvage(_files(path, ".mcap"), wanted)
        return
    with contextlib.closing(reader):
        connections = [c for c in reader.connections if wanted is None or c.topic in wanted]
        store = _store(connections)
        if connections:
            for connection, receive_ns, data in reader.messages(connections):
                yield connection.topic, receive_ns, connection.msgtype, data, store


def _open(path: Path) -> Reader | None:
    """An open reader; None for an MCAP recording that was cut off."""
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
    except (ReaderError, OSError, *_DAMAGE) as error:
        if _files(path, ".mcap"):
            return None
        raise BagError(f"{path}: {' '.join(str(error).split())}") from error


def _files(path: Path, suffix: str) -> list[Path]:
    return sorted(path.glob(f"*{suffix}")) if path.is_dir() else [path] * (path.suffix == suffix)


def _salvage(files: list[Path], wanted: Collection[str] | None) -> Iterator[_Raw]:
    store = get_typestore(Stores.EMPTY)
    for file in files:
        schemas: dict[int, Schema] = {}
        channels: dict[int, Channel] = {}
        with file.open("rb") as stream:
            for record in _records(stream, file):
                if isinstance(record, Schema):
                    schemas[record.id] = record
                    _register(store, record.name, record.encoding, record.data.decode())
                elif isinstance(record, Channel):
                    channels[record.id] = record
                elif isinstance(record, Message):
                    channel = channels[record.channel_id]
                    if wanted is None or channel.topic in wanted:
                        yield channel.topic, record.log_time, schemas[channel.schema_id].name, record.data, store


def _records(stream: Any, file: Path) -> Iterator[Any]:
    empty = True
    try:
        for record in StreamReader(stream).records:
            empty = False
            yield record
    except _DAMAGE as error:  # here it was cut off
        if empty:
            raise BagError(f"{file}: no readable record: {error}") from error


def _decode(data: bytes, type_name: str, store: Typestore) -> tuple[Any, int]:
    """A message and how many of the bytes are its own.

    Fast DDS leaves room for numbers that an empty list at the end does not have, so that there may be more bytes than
    belong to the message; rosbags refuses those.
    """
    if len(data) < 4 or data[0] != 0 or data[1] > 1:
        raise SerdeError("not in CDR")
    definition = store.get_msgdef(type_name)
    decode = definition.deserialize_cdr_le if data[1] else definition.deserialize_cdr_be
    message, end = decode(data[4:], 0, definition.cls, store)
    return message, end + 4


@cache
def _types() -> Typestore:
    """Jazzy's messages and those of this suite."""
    store = get_typestore(Stores.ROS2_JAZZY)
    try:
        folder = Path(get_package_share_directory(_OWN_PACKAGE), "msg")
    except (PackageNotFoundError, LookupError):  # a tool outside of a ROS environment
        return store
    for file in sorted(folder.glob("*.msg")):
        store.register(get_types_from_msg(file.read_text(), f"{_OWN_PACKAGE}/msg/{file.stem}"))
    return store


def _store(connections: Collection[Connection]) -> Typestore:
    """The bag's own definitions; where one is missing, today's."""
    if any(connection.msgdef.format == MessageDefinitionFormat.NONE for connection in connections):
        return _types()
    store = get_typestore(Stores.EMPTY)
    for connection in connections:
        encoding = "ros2msg" if connection.msgdef.format == MessageDefinitionFormat.MSG else "ros2idl"
        _register(store, connection.msgtype, encoding, connection.msgdef.data)
    return store


def _register(store: Typestore, name: str, encoding: str, definition: str) -> None:
    try:
        if encoding == "ros2msg":
            store.register(get_types_from_msg(definition, name))
            return
        for part in definition.split("=" * 80 + "\n"):
            store.register(get_types_from_idl(part.partition("\n")[2] if part.startswith("IDL: ") else part))
    except TypesysError as error:
        raise BagError(f"definition of {name}: {error}") from error


class Recording:
    """A rosbag2 recording being written: MCAP, with metadata.yaml when it is closed.

    What was flushed is readable (by `read`) even if the process dies before `close`.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._store = _types()
        self._connections: dict[str, Connection] = {}
        self._turn = threading.Lock()  # topics are announced by one thread while another writes
        try:
            self._writer = Writer(self.path, version=9, storage_plugin=StoragePlugin.MCAP)  # 9: Jazzy
            self._writer.open()
        except (WriterError, OSError) as error:
            raise BagError(f"{path}: {error}") from error

    def add(self, topic: str, type_name: str) -> None:
        """Announce a topic before its first message; adding it again does nothing.

        Raises BagError for a type of which no definition is known.
        """
        if topic in self._connections:
            return
        try:
            with self._turn:
                self._connections[topic] = self._writer.add_connection(
                    topic, type_name, typestore=self._store, offered_qos_profiles=[_RELIABLE]
                )
        except (TypesysError, KeyError) as error:
            raise BagError(f"{self.path}: {topic}: no definition of {type_name}") from error

    def write(self, topic: str, receive_ns: int, data: bytes) -> None:
        """One serialized message (CDR, as it came from the wire). Raises OSError when the disk is full."""
        connection = self._connections[topic]
        if connection.msgtype in _LISTS_LAST:
            with contextlib.suppress(*_DAMAGE, SerdeError):  # what cannot be decoded is kept as it came
                data = data[: _decode(data, connection.msgtype, self._store)[1]]
        with self._turn:
            self._writer.write(connection, receive_ns, data)

    def flush(self) -> None:
        """Hand everything to the operating system. Raises OSError when the disk is full."""
        with self._turn:
            storage: Any = self._writer.storage
            if storage.chunk.bio.tell():
                storage.close_chunk()
            storage.bio.flush()

    def close(self) -> None:
        """Write index and metadata.yaml. Raises OSError when the disk is full; then `abort`."""
        with self._turn:
            self._writer.close()

    def abort(self) -> None:
        """Give up without index and metadata; what was flushed stays readable."""
        self._writer.abort()

    @property
    def messages(self) -> int:
        """How many messages were written."""
        return sum(self._writer.counts.values())
