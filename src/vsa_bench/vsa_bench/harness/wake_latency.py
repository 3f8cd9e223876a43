# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Wake-up latency of the machine: how late it schedules a process of the highest priority, on every core."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from types import TracebackType

import numpy as np
from vsa_common.types import Array

PERIOD_S = 0.002

# One process a core: sleeps, and writes the excess over the requested time [s]. Ends with its parent.
_PROBE = """
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


class WakeLatency:
    """Context manager that measures on every core, every `period` [s]."""

    def __init__(self, period: float = PERIOD_S) -> None:
        self._period = period

    def __enter__(self) -> "WakeLatency":
        self._folder = tempfile.TemporaryDirectory()
        self._logs = {core: Path(self._folder.name, str(core)) for core in os.sched_getaffinity(0)}
        self._offsets = dict.fromkeys(self._logs, 0)
        self._processes = []
        for core, log in self._logs.items():
            command = [sys.executable, "-S", "-c", _PROBE, str(core), str(self._period)]
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

    def restart(self) -> None:
        """Discard the measurements taken before this call."""
        self._offsets = {core: log.stat().st_size // 8 * 8 for core, log in self._logs.items()}

    def seconds(self) -> Array:
        """Latency of each wake-up [s] since `restart`, core by core."""
        written = [log.read_bytes()[self._offsets[core] :] for core, log in self._logs.items()]
        return np.concatenate([np.frombuffer(data[: len(data) // 8 * 8]) for data in written])
