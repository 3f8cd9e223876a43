"""From the callbacks to the disk: a bounded queue and the thread that empties it into a recording."""

import shutil
import threading
import time
from collections import deque

from vsa_common.io.bags import Recording

DRAIN_S = 0.05  # how often the queue is emptied
Entry = tuple[str, int, bytes]


class Spool:
    """Writes what it is given in a thread of its own, so that a slow disk does not hold up the callbacks.

    When the disk is full (or `reserve` bytes from it) the recording is closed and `failure` says so; what comes
    after that, or finds the queue full, is counted in `dropped`.
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
        self._thread = threading.Thread(target=self._work, name="spool", daemon=True)
        self.dropped = 0
        self.longest = 0
        self.failure = ""
        self._thread.start()

    @property
    def written(self) -> int:
        """Messages in the recording."""
        return self._recording.messages

    def put(self, topic: str, receive_ns: int, data: bytes) -> None:
        """Take one serialized message of a topic that the recording knows."""
        if self.failure or len(self._queue) >= self._limit:
            self.dropped += 1
        else:
            self._queue.append((topic, receive_ns, data))

    def close(self) -> None:
        """Write what is left, then index and metadata."""
        self._ended.set()
        self._thread.join()

    def _work(self) -> None:
        flushed = time.monotonic()
        try:
            while not self._ended.wait(DRAIN_S):
                self._drain()
                if time.monotonic() - flushed >= self._flush_s:
                    flushed = time.monotonic()
                    self._recording.flush()
                    if shutil.disk_usage(self._recording.path).free < self._reserve:
                        self._give_up(f"less than {self._reserve / 1e6:.0f} MB left on the disk")
                        break
            self._drain()
            self._recording.close()
        except Exception as error:  # a full disk, mostly; whatever it is, nobody but `failure` tells of it
            self._give_up((error.strerror if isinstance(error, OSError) else None) or repr(error))
            self._recording.abort()
        self.dropped += len(self._queue)
        self._queue.clear()

    def _drain(self) -> None:
        self.longest = max(self.longest, len(self._queue))
        while self._queue:
            self._recording.write(*self._queue.popleft())

    def _give_up(self, reason: str) -> None:
        path, count = self._recording.path, self._recording.messages
        self.failure = f"{path}: {reason}; the recording ended, its {count} messages are readable"
