# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Reader of recorded samples of transmissions: CSV files and rosbag2 bags (MCAP and sqlite3)."""

import re
import struct
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from vsa_common.io.bags import read_raw, topics
from vsa_common.io.tables import read_columns
from vsa_common.ros.cdr import read_counters, read_positions, read_wrenches
from vsa_common.stamps import NANOSECONDS
from vsa_estimator.preprocessing.pairing import ENCODER, FORCE, pair_all
from vsa_estimator.settings import NodeConfig

CSV_COLUMNS = ("stamp", "force", "deflection")
TOLERANCE_NS = round(NodeConfig.pairing_tolerance * NANOSECONDS)  # the node's default
WINDOW_NS = round(NodeConfig.reorder_window * NANOSECONDS)
BATCH_SIZE = 4096  # messages of a bag that are decoded at once, in a tenth of the time
FIRST_STAMP_NS = NANOSECONDS  # start of a recording that counts from zero: zero is no valid stamp

_Decoded = tuple[NDArray[np.uint8], NDArray[np.int64], NDArray[np.float64]]  # sensors, stamps [ns], values
_TYPES = ("geometry_msgs/msg/WrenchStamped", "sensor_msgs/msg/JointState")  # of force and encoder
_FORCE_TOPIC = re.compile(r"(?P<namespace>.*/)?(?P<transmission>[^/]+)/force")
_MCAP_MAGIC = b"\x89MCAP0\r\n"


class RecordingError(ValueError):
    """A recording is not usable; the text names the file and what was expected."""


@dataclass(frozen=True)
class Recording:
    """All samples of one transmission, in the order of the file."""

    source: Path
    transmission: str
    stamp_ns: NDArray[np.int64]  # input of the estimator [ns]
    stamp: NDArray[np.float64]  # of the file [s]
    force: NDArray[np.float64]  # [N]
    deflection: NDArray[np.float64]  # [m]
    unpaired: int = 0  # messages of a bag without a counterpart of the same stamp
    complete: bool = True  # false for a bag that was cut off
    lost: NDArray[np.int64] | None = None  # samples lost before each; None where the frames are not counted

    def __len__(self) -> int:
        return len(self.stamp_ns)

    @property
    def duration(self) -> float:
        """From the first stamp to the last [s]."""
        return float(self.stamp[-1] - self.stamp[0])


def transmissions(path: Path, transmission: str | None = None, namespace: str | None = None) -> list[str]:
    """Names of the transmissions in a CSV file (one) or a bag, or the one named; of a bag those in `namespace`.

    Raises RecordingError or BagError with one line.
    """
    if path.suffix.lower() == ".csv":
        return [transmission or "transmission_1"]
    if path.is_dir() or path.suffix in (".mcap", ".db3"):
        return list(_sources(path, transmission, namespace))
    missing = "no such file" if not path.exists() else "no recording"
    raise RecordingError(f"{path}: {missing}; expected a .csv, .mcap or .db3 file, or the folder of a bag")


def read_recordings(path: Path, transmission: str | None = None, namespace: str | None = None) -> list[Recording]:
    """The recordings in a CSV file (one) or a bag (one for each transmission, or the one named, in `namespace`).

    Raises RecordingError, TableError or BagError with one line.
    """
    names = transmissions(path, transmission, namespace)
    return [read_csv(path, *names)] if path.suffix.lower() == ".csv" else read_bag(path, transmission, namespace)


def read_csv(path: Path, transmission: str) -> Recording:
    """Samples of a file with the columns stamp [s], force [N], deflection [m]; an empty cell is NaN.

    Raises RecordingError or TableError.
    """
    columns = read_columns(path, CSV_COLUMNS)
    stamp = columns["stamp"]
    usable = np.where(np.isfinite(stamp) & (np.abs(stamp) < 9e9), stamp, np.nan)
    finite = usable[np.isfinite(usable)]
    if not len(finite):
        raise RecordingError(f"{path}: line 2: expected a stamp in seconds, found none in the whole file")
    stamp_ns = np.round(np.nan_to_num(usable, nan=-1.0) * NANOSECONDS).astype(np.int64)
    if finite.min() <= 0.0:
        shift = FIRST_STAMP_NS - int(np.round(finite.min() * NANOSECONDS))
        stamp_ns = np.where(np.isfinite(usable), stamp_ns + shift, 0)
    return Recording(path, transmission, stamp_ns, stamp, columns["force"], columns["deflection"])


def read_bag(path: Path, transmission: str | None, namespace: str | None = None) -> list[Recording]:
    """Samples of the transmissions whose force and encoder are in a bag. Raises RecordingError or BagError."""
    sources = _sources(path, transmission, namespace)
    decoders = {name: _Decoder(path, *of_name) for name, of_name in sources.items()}
    handlers = {topic: handler for decoder in decoders.values() for topic, handler in decoder.handlers.items()}
    for topic, _, data in read_raw(path, list(handlers)):
        handlers[topic](data)
    complete = is_complete(path)
    recordings = []
    for name, decoder in decoders.items():
        stamp_ns, force, deflection = decoder.pairs()
        if not len(stamp_ns):
            raise RecordingError(f"{path}: {name}: no force and encoder message with the same stamp")
        unpaired = decoder.count - 2 * len(stamp_ns)
        recordings.append(
            Recording(
                path, name, stamp_ns, stamp_ns / NANOSECONDS, force, deflection,
                unpaired=unpaired, complete=complete, lost=decoder.lost_before(stamp_ns),
            )
        )  # fmt: skip
    return recordings


def is_complete(path: Path) -> bool:
    """Whether a recording was closed; false for an MCAP file without its final bytes."""
    for file in sorted(path.glob("*.mcap")) if path.is_dir() else [path] * (path.suffix == ".mcap"):
        with file.open("rb") as stream:
            stream.seek(max(file.stat().st_size - len(_MCAP_MAGIC), 0))
            if stream.read() != _MCAP_MAGIC:
                return False
    return True


class _Decoder:
    """Force and encoder messages of one transmission, decoded in batches in the order of the bag."""

    def __init__(self, path: Path, force_topic: str, encoder_topic: str, counter_topic: str) -> None:
        self.count = 0
        self.handlers: dict[str, Callable[[bytes], None]] = {
            force_topic: partial(self._add, FORCE), encoder_topic: partial(self._add, ENCODER),
            counter_topic: self._add_counters,
        }  # fmt: skip
        self._path = path
        self._pending: list[tuple[int, bytes]] = []
        self._decoded: list[_Decoded] = []
        self._counted: tuple[list[int], list[int]] = [], []  # stamps [ns] and sequence numbers

    def _add(self, sensor: int, data: bytes) -> None:
        self.count += 1
        self._pending.append((sensor, data))
        if len(self._pending) >= BATCH_SIZE:
            self._decode_pending()

    def pairs(self) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
        """Stamps [ns], forces [N] and deflections [m] of the samples."""
        self._decode_pending()
        sensors, stamps, values = (np.concatenate(column) for column in zip(*self._decoded, strict=True))
        return pair_all(sensors, stamps, values, TOLERANCE_NS, WINDOW_NS)

    def _add_counters(self, data: bytes) -> None:
        try:
            stamps_ns, sequence = read_counters(data)
        except (struct.error, IndexError) as error:
            raise RecordingError(f"{self._path}: capture_counters: a message ends too early: {error}") from error
        self._counted[0].extend(stamps_ns)
        self._counted[1].extend(sequence)

    def lost_before(self, stamp_ns: NDArray[np.int64]) -> NDArray[np.int64] | None:
        """Samples lost before each stamp (n,) [ns]: missing numbers, and numbers without a sample; None without any."""
        stamps, sequence = (np.array(column, np.int64) for column in self._counted)
        if not len(stamps):
            return None
        gaps, lost = np.diff(sequence) - 1, np.zeros(len(stamp_ns) + 1, np.int64)
        found = np.flatnonzero(gaps > 0)
        increasing = np.maximum.accumulate(stamp_ns)
        np.add.at(lost, np.searchsorted(increasing, stamps[found + 1]), gaps[found])
        np.add.at(lost, np.searchsorted(increasing, stamps[~np.isin(stamps, stamp_ns)]), 1)
        return lost[:-1]

    def _decode_pending(self) -> None:
        sensors = np.array([sensor for sensor, _ in self._pending], np.uint8)
        stamps, values = np.empty(len(sensors), np.int64), np.empty(len(sensors))
        sensor_topics = tuple(self.handlers)[:2]
        for topic, sensor, read in zip(sensor_topics, (FORCE, ENCODER), (read_wrenches, read_positions), strict=True):
            messages = [data for one, data in self._pending if one == sensor]
            if not messages:
                continue
            try:
                stamps[sensors == sensor], values[sensors == sensor] = read(messages)
            except (struct.error, IndexError) as error:
                raise RecordingError(f"{self._path}: {topic}: a message ends too early: {error}") from error
        self._decoded.append((sensors, stamps, values))
        self._pending = []


def _sources(path: Path, transmission: str | None, namespace: str | None) -> dict[str, tuple[str, str, str]]:
    """Topics of force, encoder and sequence numbers of each transmission in `namespace`, or of the one named."""
    types = {name: topic.type_name for name, topic in topics(path).items()}
    found: dict[str, tuple[str, str, str]] = {}
    for name in sorted(types):
        match = _FORCE_TOPIC.fullmatch(name)
        encoder = name.removesuffix("force") + "encoder"
        if not match or (types[name], types.get(encoder)) != _TYPES:
            continue
        if namespace is not None and (match["namespace"] or "").strip("/") != namespace.strip("/"):
            continue
        if transmission in (None, match["transmission"]) and match["transmission"] in found:
            first = found[match["transmission"]][0]
            raise RecordingError(f"{path}: {first} and {name}: choose a joint with --namespace")
        found[match["transmission"]] = (name, encoder, name.removesuffix("force") + "capture_counters")
    if not found:
        prefix = "..." if namespace is None else f"/{namespace.strip('/')}".rstrip("/")
        raise RecordingError(
            f"{path}: expected {prefix}/transmission_N/force (WrenchStamped) and .../encoder (JointState), "
            "found neither"
        )
    if transmission is None:
        return found
    if transmission not in found:
        raise RecordingError(f"{path}: no {transmission}; it holds {', '.join(found)}")
    return {transmission: found[transmission]}
