# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Writing of rosbag2 recordings as MCAP."""

import contextlib
import threading
from pathlib import Path
from typing import Any

from rosbags.interfaces import Connection, Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
from rosbags.serde import SerdeError
from rosbags.typesys import TypesysError
from vsa_common.io.bags.definitions import PARSER_ERRORS, BagError, decode, installed_types

# Types that end in sequences: for these Fast DDS returns more bytes than the message has.
_SURPLUS_BYTES = ("sensor_msgs/msg/JointState",)
_INFINITE = QosTime(9223372036, 854775807)
_RELIABLE = Qos(
    history=QosHistory.KEEP_LAST,
    depth=1000,
    reliability=QosReliability.RELIABLE,
    durability=QosDurability.VOLATILE,
    deadline=_INFINITE,
    lifespan=_INFINITE,
    liveliness=QosLiveliness.AUTOMATIC,
    liveliness_lease_duration=_INFINITE,
    avoid_ros_namespace_conventions=False,
)


class Recording:
    """A rosbag2 recording in progress: MCAP, with metadata.yaml once it is closed.

    Flushed messages are readable (by `read`) even if the process dies before `close`.
    """

    def __init__(self, path: str | Path) -> None:
        """Create the bag's folder. Raises BagError if it exists or cannot be written."""
        self.path = Path(path)
        self._store = installed_types()
        self._connections: dict[str, Connection] = {}
        self._lock = threading.Lock()  # one thread adds topics while another writes
        try:
            self._writer = Writer(self.path, version=9, storage_plugin=StoragePlugin.MCAP)  # 9: Jazzy
            self._writer.open()
        except (WriterError, OSError) as error:
            raise BagError(f"{path}: {error}") from error

    def add(self, topic: str, type_name: str) -> None:
        """Declare a topic before its first message; a second declaration has no effect.

        Raises BagError for a type without a definition.
        """
        if topic in self._connections:
            return
        try:
            with self._lock:
                self._connections[topic] = self._writer.add_connection(
                    topic, type_name, typestore=self._store, offered_qos_profiles=[_RELIABLE]
                )
        except (TypesysError, KeyError) as error:
            raise BagError(f"{self.path}: {topic}: no definition of {type_name}") from error

    def write(self, topic: str, receive_ns: int, data: bytes) -> None:
        """Write one serialized message (CDR, as received). Raises OSError when the disk is full."""
        connection = self._connections[topic]
        if connection.msgtype in _SURPLUS_BYTES:
            with contextlib.suppress(*PARSER_ERRORS, SerdeError):  # undecodable bytes are written as received
                data = data[: decode(data, connection.msgtype, self._store)[1]]
        with self._lock:
            self._writer.write(connection, receive_ns, data)

    def flush(self) -> None:
        """Pass all messages to the operating system. Raises OSError when the disk is full."""
        with self._lock:
            storage: Any = self._writer.storage
            if storage.chunk.bio.tell():
                storage.close_chunk()
            storage.bio.flush()

    def close(self) -> None:
        """Write index and metadata.yaml. Raises OSError when the disk is full; then call `abort`."""
        with self._lock:
            self._writer.close()

    def abort(self) -> None:
        """Close without index and metadata; flushed messages stay readable."""
        self._writer.abort()

    @property
    def messages(self) -> int:
        """Number of messages written."""
        return sum(self._writer.counts.values())
