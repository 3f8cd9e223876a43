# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Programs of the suite, and a process to start."""

from dataclasses import dataclass
from typing import NamedTuple


class Program(NamedTuple):
    """An executable and the names of its nodes."""

    package: str
    executable: str
    nodes: tuple[str, ...]


@dataclass(frozen=True)
class Process:
    """One process to start. Empty name and namespace: those of the executable."""

    package: str
    executable: str
    name: str = ""
    namespace: str = ""
    parameter_files: tuple[str, ...] = ()
    arguments: tuple[str, ...] = ()
    log_level: str = ""
    on_exit: str = ""  # argument of the launch file, for nodes of the suite
