# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`./vsa bench soak`: random frames, hours of motion through the filter, memory of the running suite."""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from vsa_bench.soak.filter import soak_filter, soak_frames
from vsa_common.terminal import show_table

FRAMES, HOURS, MINUTES = 1_000_000, 24.0, 10.0
FLAT_MB = 20.0  # permitted growth of a process


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; its exit code: 1 where a figure is out of bounds."""
    parser = argparse.ArgumentParser(prog="bench soak", description=__doc__)
    parser.add_argument("--frames", type=int, default=FRAMES, metavar="N", help="random frames (%(default)s; 0: none)")
    parser.add_argument("--hours", type=float, default=HOURS, help="simulated hours through the filter (%(default)s)")
    parser.add_argument(
        "--live", type=float, default=MINUTES, metavar="MIN", help="minutes of the running suite (%(default)s)"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there")
    options = parser.parse_args(argv)
    figures: dict[str, Any] = {}
    if options.frames:
        figures["frames"] = soak_frames(options.frames)
    if options.hours:
        figures["filter"] = soak_filter(options.hours)
    _write(options.json, figures)  # the running suite may fail after hours
    if options.live:
        from vsa_bench.soak.live import soak_live

        figures["live"] = soak_live(60.0 * options.live)
        _write(options.json, figures)
    rows = [[part, name, str(value)] for part, values in figures.items() for name, value in values.items()]
    violations = out_of_bounds(figures)
    show_table("Soak", ("", "figure", "value"), rows, "; ".join(violations) or "within bounds", texts=2)
    return 1 if violations else 0


def _write(path: Path | None, figures: dict[str, Any]) -> None:
    if path:
        path.write_text(json.dumps(figures, indent=2) + "\n")


def out_of_bounds(figures: dict[str, Any]) -> list[str]:
    """One text for each figure that is out of bounds.

    >>> out_of_bounds({"filter": {"unsound": 0, "rss_growth_mb": 50.0}})
    ['filter: memory grew by 50.0 MB']
    """
    found = []
    for part, values in figures.items():
        for name in ("unsound", "wrong_but_valid", "samples_lost"):
            found += [f"{part}: {name} {values[name]}"] if values.get(name) else []
        growths = values.get("rss_growth_mb", 0.0)
        for process, growth in (growths if isinstance(growths, dict) else {"memory": growths}).items():
            found += [f"{part}: {process} grew by {growth} MB"] if growth > FLAT_MB else []
        for process, growth in values.get("descriptors_growth", {}).items():
            found += [f"{part}: {process} opened {growth} descriptors"] if growth > 0 else []
    return found


if __name__ == "__main__":
    sys.exit(main())
