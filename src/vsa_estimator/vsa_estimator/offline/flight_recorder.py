# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Flight recorder: keeps the last samples and writes them to a CSV file for `replay` at an event of the estimate."""

import contextlib
import time
from array import array
from datetime import datetime, timezone
from pathlib import Path
from threading import Thread
from typing import Any

from vsa_common.config.configuration import ConfigurationError
from vsa_common.stamps import NANOSECONDS
from vsa_common.types import ResetReason, Status
from vsa_estimator.output.estimate import Estimate
from vsa_estimator.settings import FlightRecorderConfig

EVENT_STATUSES = (Status.DEGRADED, Status.FAULT)
ROWS_PER_WRITE = 64  # bounds the time for which the writer holds the interpreter lock
WRITE_PAUSE_S = 0.001  # between two writes


class FlightRecorder:
    """Records the samples before an event and some after it, one file for each event.

    A reset and a change to one of EVENT_STATUSES are events. An event during the recording of another belongs to it;
    no sample is written twice.
    """

    def __init__(self, config: FlightRecorderConfig, name: str, reset_count: int = 0) -> None:
        """`name` is the prefix of the file names; a reset beyond `reset_count` is an event.

        Raises ConfigurationError for a folder that cannot be created.
        """
        self.files = 0  # written
        self.failed = ""  # error of the last failed write
        self._config = config
        self._name = name
        self._folder = Path(config.folder).expanduser()
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ConfigurationError(f"flight_recorder.folder = {config.folder!r}: {error.strerror}") from error
        self._stamps = array("q", bytes(8 * config.samples))
        self._forces, self._deflections = (array("d", bytes(8 * config.samples)) for _ in range(2))
        self._next = self._count = 0
        self._event = ""
        self._due_ns = 0
        self._reset_count = reset_count
        self._status = Status.INITIALIZING
        self._writer: Thread | None = None

    def add(self, stamp_ns: int, force: float, deflection: float) -> None:
        """Keep one sample: stamp [ns], force [N], deflection [m]."""
        i = self._next
        self._stamps[i], self._forces[i], self._deflections[i] = stamp_ns, force, deflection
        self._next = i + 1 if i + 1 < self._config.samples else 0
        self._count = min(self._count + 1, self._config.samples)

    def watch(self, estimate: Estimate) -> None:
        """Detect an event; it is written by a separate thread, `after` [s] of the configuration later."""
        event = ""
        if estimate.reset_count > self._reset_count:
            event = f"reset_{ResetReason(estimate.reset_reason).name}"
        elif estimate.status is not self._status and estimate.status in EVENT_STATUSES:
            event = estimate.status.name
        self._reset_count, self._status = estimate.reset_count, estimate.status
        if event and not self._event:
            self._event, self._due_ns = event, estimate.stamp_ns + int(self._config.after * NANOSECONDS)
        if self._event and not 0 < self._due_ns - estimate.stamp_ns <= self._config.after * NANOSECONDS:
            self._write()

    def close(self) -> None:
        """Write a pending event immediately and wait until it is written."""
        self._wait()
        if self._event:
            self._write()
        self._wait()

    def _wait(self) -> None:
        if self._writer is not None:
            self._writer.join()

    def _write(self) -> None:
        if self._writer is not None and self._writer.is_alive():
            return
        columns = [self._in_order(column) for column in (self._stamps, self._forces, self._deflections)]
        now = datetime.now(timezone.utc).strftime("%Y%m%dT%H%M%S.%f")
        path = self._folder / f"{self._name}_{now}_{self._event}.csv"
        self._event, self._count = "", 0
        self._writer = Thread(target=self._save, args=(path, columns), name="flight recorder")
        self._writer.start()

    def _in_order(self, ring: "array[Any]") -> "array[Any]":
        """The samples of a ring buffer, oldest first."""
        oldest = self._next - self._count
        return ring[oldest:] + ring[: self._next] if oldest < 0 else ring[oldest : self._next]

    def _save(self, path: Path, columns: "list[array[Any]]") -> None:
        partial_file = path.with_suffix(".part")
        try:
            with partial_file.open("w") as file:
                file.write("stamp,force,deflection\n")
                for first in range(0, len(columns[0]), ROWS_PER_WRITE):
                    rows = zip(*(column[first : first + ROWS_PER_WRITE] for column in columns), strict=True)
                    for stamp, force, deflection in rows:
                        seconds, rest = divmod(stamp, NANOSECONDS)
                        file.write(f"{seconds}.{rest:09d},{force!r},{deflection!r}\n")
                    time.sleep(WRITE_PAUSE_S)
            partial_file.rename(path)
            self.files += 1
            for old in sorted(self._folder.glob(f"{self._name}_*.csv"))[: -self._config.files]:
                old.unlink(missing_ok=True)
        except OSError as error:
            self.failed = f"{path}: {error.strerror}"
            with contextlib.suppress(OSError):
                partial_file.unlink(missing_ok=True)
