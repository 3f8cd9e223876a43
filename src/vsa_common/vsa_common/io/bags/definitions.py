# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Message definitions: of a bag, of this suite, and of ROS 2 Jazzy; decoding by them."""

import struct
from collections.abc import Collection
from functools import cache
from pathlib import Path
from typing import Any

from ament_index_python.packages import PackageNotFoundError, get_package_share_directory
from mcap.exceptions import McapError
from rosbags.interfaces import Connection, MessageDefinitionFormat
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, TypesysError, get_types_from_idl, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

OWN_PACKAGE = "vsa_msgs"
# Exceptions of the parsers of rosbags and mcap for a record that is truncated.
PARSER_ERRORS = (McapError, struct.error, EOFError, TypeError, ValueError, LookupError, OverflowError, MemoryError)


class BagError(ValueError):
    """A bag cannot be read or written; the text names the file and the reason."""


@cache
def installed_types() -> Typestore:
    """Definitions of ROS 2 Jazzy and of this suite."""
    store = get_typestore(Stores.ROS2_JAZZY)
    try:
        folder = Path(get_package_share_directory(OWN_PACKAGE), "msg")
    except (PackageNotFoundError, LookupError):  # a tool outside of a ROS environment
        return store
    for file in sorted(folder.glob("*.msg")):
        store.register(get_types_from_msg(file.read_text(), f"{OWN_PACKAGE}/msg/{file.stem}"))
    return store


def recorded_types(connections: Collection[Connection]) -> Typestore:
    """Definitions that a bag contains; the installed ones where it lacks one."""
    if any(connection.msgdef.format == MessageDefinitionFormat.NONE for connection in connections):
        return installed_types()
    store = get_typestore(Stores.EMPTY)
    for connection in connections:
        encoding = "ros2msg" if connection.msgdef.format == MessageDefinitionFormat.MSG else "ros2idl"
        register(store, connection.msgtype, encoding, connection.msgdef.data)
    return store


def register(store: Typestore, name: str, encoding: str, definition: str) -> None:
    """Add a definition in `encoding` (ros2msg or ros2idl) to `store`. Raises BagError where it cannot be parsed."""
    try:
        if encoding == "ros2msg":
            store.register(get_types_from_msg(definition, name))
            return
        for part in definition.split("=" * 80 + "\n"):
            store.register(get_types_from_idl(part.partition("\n")[2] if part.startswith("IDL: ") else part))
    except TypesysError as error:
        raise BagError(f"definition of {name}: {error}") from error


def decode(data: bytes, type_name: str, store: Typestore) -> tuple[Any, int]:
    """A message and its length in bytes, which may be less than that of `data`.

    Fast DDS reserves alignment padding for the elements of a sequence at the end even if the sequence is empty;
    rosbags' own deserialization rejects such surplus bytes.
    """
    if len(data) < 4 or data[0] != 0 or data[1] > 1:
        raise SerdeError("not in CDR")
    definition = store.get_msgdef(type_name)
    deserialize = definition.deserialize_cdr_le if data[1] else definition.deserialize_cdr_be
    message, end = deserialize(data[4:], 0, definition.cls, store)
    return message, end + 4
