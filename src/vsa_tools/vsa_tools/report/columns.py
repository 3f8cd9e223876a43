# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Messages of one topic as columns of numbers."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from vsa_common.io.bags import Topic
from vsa_common.stamps import NANOSECONDS

Floats = NDArray[np.float64]

_MAX_STAMP_OFFSET_S = 10.0  # [s] a stamp further from the others is invalid: no transport delay is so long


@dataclass(frozen=True)
class Series:
    """The messages of one topic. `time` counts from the start of the run; it is NaN where a stamp is invalid."""

    topic: Topic
    stamp_ns: NDArray[np.int64]
    receive_ns: NDArray[np.int64]
    time: Floats  # [s]
    columns: dict[str, Floats]
    texts: dict[str, Any] = field(default_factory=dict)  # of the last message
    flagged: dict[str, Any] = field(default_factory=dict)  # all fields of the last message with a valid sequence

    def __len__(self) -> int:
        return len(self.stamp_ns)

    def __getitem__(self, name: str) -> Floats:
        """A column; all NaN where the message definition of the bag lacks the field."""
        return self.columns.get(name, np.full(len(self), np.nan))

    def std(self, name: str) -> Floats:
        """Standard deviation of a quantity that has a variance field."""
        return np.sqrt(np.maximum(self[f"{name}_variance"], 0.0))

    def valid(self, name: str) -> NDArray[np.bool_]:
        """Validity of a quantity in each message."""
        return self[f"{name}_valid"] == 1.0


class ColumnBuilder:
    """Collects the fields `names` of the messages of one topic into a Series.

    The fields `sequences`, which are large, are kept of one message only: the last one in which the field `flag` is
    true.
    """

    def __init__(self, topic: Topic, names: Sequence[str], sequences: Sequence[str] = (), flag: str = "") -> None:
        self.topic = topic
        self.stamps: list[int] = []
        self._receives: list[int] = []
        self._rows: list[tuple[Any, ...]] = []
        self._names, self._sequences = names, sequences
        self._columns = [i for i, name in enumerate(names) if name not in sequences]
        self._flag = names.index(flag) if sequences else -1
        self._flagged: tuple[Any, ...] = ()

    def add(self, receive_ns: int, stamp_ns: int, values: tuple[Any, ...]) -> None:
        """Add the fields of one message."""
        self._receives.append(receive_ns)
        self.stamps.append(stamp_ns)
        if self._sequences:
            self._flagged = values if values[self._flag] else self._flagged
            values = tuple(values[i] for i in self._columns)
        self._rows.append(values)

    def series(self, start_ns: int) -> Series:
        """All messages; their time counts from `start_ns`."""
        stamps = np.array(self.stamps, dtype=np.int64)
        receives = np.array(self._receives, dtype=np.int64)
        time = (stamps - start_ns) / NANOSECONDS
        delay = (receives - stamps) / NANOSECONDS
        time[np.abs(delay - np.median(delay)) > _MAX_STAMP_OFFSET_S] = np.nan
        names = [self._names[i] for i in self._columns]
        fields = dict(zip(names, zip(*self._rows, strict=True), strict=True))
        flagged = dict(zip(self._names, self._flagged, strict=True)) if self._flagged else {}
        texts = {name: values[-1] for name, values in fields.items() if isinstance(values[-1], str | list)}
        columns = {name: np.array(values, dtype=float) for name, values in fields.items() if name not in texts}
        return Series(self.topic, stamps, receives, time, columns, texts, flagged)


def first_stamp(stamps: list[int]) -> int:
    """The earliest valid stamp [ns]; outliers are ignored. A stamp of zero, before the first sample, is none."""
    array = np.array(stamps, dtype=np.int64)
    array = array[array > 0]
    low, high = np.quantile(array, [0.02, 0.98])
    margin = _MAX_STAMP_OFFSET_S * NANOSECONDS + (high - low)
    return int(array[(array >= low - margin) & (array <= high + margin)].min())
