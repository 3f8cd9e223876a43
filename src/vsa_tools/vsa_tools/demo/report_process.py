# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The report in a separate process, which imports its libraries while the demo stops its nodes."""

import subprocess
import sys
from pathlib import Path

from vsa_common.ros.subprocesses import ProcessError

# The kernel kills it with its parent; it ends without a report on an empty line or end of input.
_PROGRAM = """
import ctypes, signal, sys
ctypes.CDLL(None).prctl(1, signal.SIGKILL)
from vsa_tools.report.command import write
folder = sys.stdin.readline().rstrip("\\n")
if folder:
    write(f"{folder}/bag", folder, print_files=False)
"""


class Reporter:
    """Starts the process at once; `write` sends it the folder of the run."""

    def __init__(self) -> None:
        self._popen = subprocess.Popen(
            [sys.executable, "-W", "ignore", "-c", _PROGRAM],
            stdin=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )

    def write(self, folder: Path) -> None:
        """Write report.html of the run in `folder`. Raises ProcessError with the reason on failure."""
        _, errors = self._popen.communicate(f"{folder}\n")
        if self._popen.returncode:
            reason = errors.strip().splitlines()[-1] if errors.strip() else f"code {self._popen.returncode}"
            raise ProcessError(f"the report could not be written: {reason}")

    def __enter__(self) -> "Reporter":
        return self

    def __exit__(self, *_: object) -> None:
        """End the process if it still waits for a folder."""
        if self._popen.poll() is None:
            self._popen.kill()
            self._popen.communicate()
