# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Ground truth of a run as a CSV file, for tools and tests; no estimator reads it."""

from collections.abc import Sequence
from pathlib import Path
from types import TracebackType

from vsa_simulator.rig.dynamics import TRUTH

HEADER = ("sample", *TRUTH)
_ROW = "%d" + ",%.10g" * len(TRUTH) + "\n"


class TruthFile:
    """Writes a row for each sample, SI, columns as in `HEADER`. Raises OSError where the file cannot be written."""

    def __init__(self, path: str | Path) -> None:
        self._file = open(path, "w", buffering=1 << 16)  # noqa: SIM115 (closed by close)
        self._file.write(",".join(HEADER) + "\n")

    def write(self, sample: int, row: Sequence[float]) -> None:
        """Append the truth of one sample."""
        self._file.write(_ROW % (sample, *row))

    def close(self) -> None:
        """Flush and close; closing twice is no error."""
        self._file.close()

    def __enter__(self) -> "TruthFile":
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, at: TracebackType | None) -> None:
        self.close()
