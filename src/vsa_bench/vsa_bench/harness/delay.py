"""How late the machine itself wakes a process that comes before all others: nothing on it can be on time meanwhile."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

PERIOD_S = 0.002

# One a core: sleeps, and writes down how much longer than it had asked for. Ends with whoever started it.
_WATCH = """
import os, struct, sys, time
core, period, parent = int(sys.argv[1]), float(sys.argv[2]), os.getppid()
os.sched_setaffinity(0, {core})
try:
    os.setpriority(os.PRIO_PROCESS, 0, -20)
except PermissionError:
    pass
while os.getppid() == parent:
    last = time.monotonic()
    time.sleep(period)
    os.write(1, struct.pack("d", time.monotonic() - last - period))
"""


class Lateness:
    """Measures on every core while it is entered, every `period` [s]."""

    def __init__(self, period: float = PERIOD_S) -> None:
        self._period = period

    def __enter__(self) -> "Lateness":
        self._folder = tempfile.TemporaryDirectory()
        self._logs = {core: Path(self._folder.name, str(core)) for core in os.sched_getaffinity(0)}
        self._begins = dict.fromkeys(self._logs, 0)
        self._processes = []
        for core, log in self._logs.items():
            command = [sys.executable, "-S", "-c", _WATCH, str(core), str(self._period)]
            with log.open("wb") as output:
                self._processes.append(subprocess.Popen(command, stdout=output, stderr=subprocess.DEVNULL))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for process in self._processes:
            process.kill()
            process.wait()
        self._folder.cleanup()

    def forget(self) -> None:
        """Begin anew."""
        self._begins = {core: log.stat().st_size // 8 * 8 for core, log in self._logs.items()}

    def seconds(self) -> NDArray[np.float64]:
        """How late each waking was [s] since `forget`, core by core."""
        written = [log.read_bytes()[self._begins[core] :] for core, log in self._logs.items()]
        return np.concatenate([np.frombuffer(data[: len(data) // 8 * 8]) for data in written])
