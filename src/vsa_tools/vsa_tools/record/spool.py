# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""A bounded queue between callbacks and disk, and the thread that writes it to a recording."""

import shutil
import threading
import time
from collections import deque

from vsa_common.io.bags import Recording

DRAIN_S = 0.05  # [s] between two writes: few wake-ups, short queue
Entry = tuple[str, int, bytes]


class Spool:
    """Writes messages in a thread, so that a slow disk does not block the callbacks.

    When less than `reserve` bytes are free, or a write fails, the recording is closed and `failure` has the reason.
    `dropped` counts later messages and those that find the queue full (`limit` messages).
    """

    def __init__(
        self, recording: Recording, limit: int = 100_000, flush_s: float = 1.0, reserve: int = 16_000_000
    ) -> None:
        self._recording = recording
        self._queue: deque[Entry] = deque()
        self._limit = limit
        self._flush_s = flush_s
        self._reserve = reserve
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="spool", daemon=True)
        self.dropped = 0
        self.longest_queue = 0
        self.failure = ""
        self._thread.start()

    def set_limits(self, limit: int, flush_s: float, reserve: int) -> None:
        """Apply another limit of the queue [messages], period of the flushes [s] and free space [byte]."""
        self._limit, self._flush_s, self._reserve = limit, flush_s, reserve

    @property
    def written(self) -> int:
        """Messages in the recording."""
        return self._recording.messages

    def put(self, topic: str, receive_ns: int, data: bytes) -> None:
        """Append one serialized message of a topic of the recording; `receive_ns` is its time of arrival."""
        if self.failure or len(self._queue) >= self._limit:
            self.dropped += 1
        else:
            self._queue.append((topic, receive_ns, data))

    def close(self) -> None:
        """Write the queue, then index and metadata."""
        self._ended.set()
        self._thread.join()

    def _run(self) -> None:
        flushed = time.monotonic()
        try:
            while not self._ended.wait(DRAIN_S):
                self._drain()
                if time.monotonic() - flushed >= self._flush_s:
                    flushed = time.monotonic()
                    self._recording.flush()
                    if shutil.disk_usage(self._recording.path).free < self._reserve:
                        self._fail(f"less than {self._reserve / 1e6:.0f} MB left on the disk")
                        break
            self._drain()
            self._recording.close()
        except Exception as error:  # mostly a full disk; `failure` is the only report of an error in this thread
            self._fail((error.strerror if isinstance(error, OSError) else None) or repr(error))
            self._recording.abort()
        self.dropped += len(self._queue)
        self._queue.clear()

    def _drain(self) -> None:
        self.longest_queue = max(self.longest_queue, len(self._queue))
        while self._queue:
            self._recording.write(*self._queue.popleft())

    def _fail(self, reason: str) -> None:
        path, count = self._recording.path, self._recording.messages
        self.failure = f"{path}: {reason}; the recording ended, its {count} messages are readable"
