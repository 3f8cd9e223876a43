# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Processor time and memory of a process, and steal time of the machine, from /proc."""

import os
from pathlib import Path

_TICKS = os.sysconf("SC_CLK_TCK")
_PAGE = os.sysconf("SC_PAGE_SIZE")


def cpu_seconds(pid: int) -> float:
    """Processor time of all threads of a process [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / _TICKS


def resident_mb(pid: int) -> float:
    """Resident memory of a process [MB]."""
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * _PAGE / 1e6


def stolen_seconds() -> float:
    """Steal time of all cores [s]: runnable, while the hypervisor ran others."""
    return int(Path("/proc/stat").read_text().split("\n", 1)[0].split()[8]) / _TICKS
