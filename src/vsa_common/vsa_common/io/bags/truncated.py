# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Messages of MCAP files without an index: the writing process ended before it closed them."""

from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

from mcap.records import Channel, Message, Schema
from mcap.stream_reader import StreamReader
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore
from vsa_common.io.bags.definitions import PARSER_ERRORS, BagError, register

RawMessage = tuple[str, int, str, bytes, Typestore]  # topic, receive time [ns], type, CDR, definitions


def read_sequentially(files: list[Path], wanted: Collection[str] | None) -> Iterator[RawMessage]:
    """Messages of the `wanted` topics (None: all) up to the first damaged record of each file, in the file's order."""
    store = get_typestore(Stores.EMPTY)
    for file in files:
        schemas: dict[int, Schema] = {}
        channels: dict[int, Channel] = {}
        with file.open("rb") as stream:
            for record in _records(stream, file):
                if isinstance(record, Schema):
                    schemas[record.id] = record
                    register(store, record.name, record.encoding, record.data.decode())
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
    except PARSER_ERRORS as error:  # the end of the intact part
        if empty:
            raise BagError(f"{file}: no readable record: {error}") from error
