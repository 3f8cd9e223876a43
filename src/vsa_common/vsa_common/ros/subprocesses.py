# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Child processes in sessions of their own that end with the process that started them."""

import ctypes
import os
import signal
import subprocess
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType

from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from vsa_common.ros.realtime import renice

STOP_S = 5.0  # [s] from a signal to the next stronger one
ORPHAN_S = 3  # [s] from the death of the parent to SIGKILL
TAIL_LINES = 12  # of a log in an error text

_PR_SET_PDEATHSIG = 1
_LIBC = ctypes.CDLL(None, use_errno=True)
# A shell that reads a process group per line, and "done" after all have ended. End of file: the parent is dead.
_GUARD = (
    'while read -r word; do case $word in done) exit;; *) all="$all -$word";; esac; done; '
    f"sleep {ORPHAN_S}; for one in $all; do kill -KILL $one 2>/dev/null; done"
)


class ProcessError(RuntimeError):
    """A process could not be started or failed; the text names it and contains the end of its log."""


def executable(package: str, name: str) -> str:
    """Path of a ROS executable, as in `ros2 run`. Raises ProcessError where there is none."""
    try:
        path = Path(get_package_prefix(package), "lib", package, name)
    except (PackageNotFoundError, LookupError) as error:
        raise ProcessError(f"package {package} is not in the environment: {error}") from error
    if not path.exists():
        raise ProcessError(f"no executable {name} in package {package} ({path})")
    return str(path)


def end_with(parent: int) -> None:
    """Request SIGTERM for this process at the end of its parent, whatever ends that."""
    _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != parent:  # the parent ended before the request
        os._exit(1)


class Process:
    """A process in a session of its own, with its output in the file `log`."""

    def __init__(self, name: str, command: Sequence[str], log: Path, env: Mapping[str, str], nice: int = 0) -> None:
        self.name = name
        self.log = log
        parent = os.getpid()

        def prepare() -> None:
            end_with(parent)
            if nice:
                with suppress(PermissionError):  # it runs at the nice value of its parent
                    renice(nice)

        with log.open("wb") as output:
            self._popen = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                env=dict(env),
                start_new_session=True,
                preexec_fn=prepare,
            )

    @property
    def pid(self) -> int:
        """Process id; also the id of its session."""
        return self._popen.pid

    @property
    def code(self) -> int | None:
        """Exit code; None while it runs."""
        return self._popen.poll()

    def signal(self, number: int) -> None:
        """Send a signal to the process if it runs."""
        if self.code is None:
            self._popen.send_signal(number)

    def wait(self, seconds: float) -> int | None:
        """Exit code; None if the process runs for longer than `seconds`."""
        try:
            return self._popen.wait(max(seconds, 0.0))
        except subprocess.TimeoutExpired:
            return None

    def kill(self) -> None:
        """Kill all processes of its session."""
        try:
            os.killpg(self.pid, signal.SIGKILL)
        except ProcessLookupError:
            return
        self._popen.wait()

    def tail(self) -> str:
        """The last lines of its output."""
        lines = self.log.read_text(errors="replace").splitlines()[-TAIL_LINES:]
        return "\n".join(f"  {line}" for line in lines) or "  (no output)"


class Group:
    """Processes by name; the end of the `with` block stops those that run.

    If this process is killed, they get SIGTERM at once and SIGKILL after `ORPHAN_S`.
    """

    def __init__(self, logs: Path, env: Mapping[str, str]) -> None:
        self._logs = logs
        self._env = env
        self._processes: dict[str, Process] = {}
        self._guard = subprocess.Popen(["sh", "-c", _GUARD], stdin=subprocess.PIPE, start_new_session=True, text=True)
        logs.mkdir(parents=True, exist_ok=True)

    def __enter__(self) -> "Group":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        self.close()

    def close(self, last: str = "") -> None:
        """Stop all processes that run, the process `last` after the others."""
        try:
            self.stop(*(name for name in self._processes if name != last))
            self.stop(*(name for name in self._processes if name == last))
        finally:
            for process in self._processes.values():
                process.kill()
            self._notify_guard("done")
            self._guard.wait()

    def start(self, name: str, command: Sequence[str], nice: int = 0) -> Process:
        """Start a process."""
        process = Process(name, command, self._logs / f"{name}.log", self._env, nice)
        self._processes[name] = process
        self._notify_guard(str(process.pid))
        return process

    def __getitem__(self, name: str) -> Process:
        return self._processes[name]

    def check(self) -> None:
        """Raise ProcessError if a process has ended with an error."""
        for process in self._processes.values():
            if process.code:
                raise ProcessError(f"{process.name} ended with code {process.code}:\n{process.tail()}")

    def stop(self, *names: str) -> None:
        """Send SIGINT to all of them, then SIGTERM, then SIGKILL, until each has ended."""
        for number in (signal.SIGINT, signal.SIGTERM):
            for name in names:
                self._processes[name].signal(number)
            end = time.monotonic() + STOP_S
            if None not in [self._processes[name].wait(end - time.monotonic()) for name in names]:
                break
        for name in names:
            self._processes[name].kill()

    def _notify_guard(self, line: str) -> None:
        assert self._guard.stdin
        try:
            self._guard.stdin.write(f"{line}\n")
            self._guard.stdin.flush()
        except BrokenPipeError:  # the guard was killed; the processes' own parent-death signal remains
            pass
