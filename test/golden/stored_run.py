# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Figures that the tools compute from a stored run of `./vsa demo --scenario stiffness_steps`."""

import argparse
import json
import re
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from vsa_tools.evaluation.run_summary import summarise
from vsa_tools.report.command import all_tables, read_run
from vsa_tools.report.figures import figure_pages
from vsa_tools.report.truth import read_truth
from vsa_tools.scenarios.stiffness_steps import Scenario

ARCHIVE = Path(__file__).parent / "stored_run.tar.xz"
NUMBER = re.compile(r"[-+]?\d[\d.]*(?:e[-+]?\d+)?")


def figures() -> dict[str, np.ndarray]:
    """Numbers of summary.json, control.json, and of each figure and table of the report."""
    with tempfile.TemporaryDirectory() as temporary:
        shutil.unpack_archive(ARCHIVE, temporary)
        folder = Path(temporary) / "run"
        found = {"summary.json": _leaves(summarise(folder, [])), "control.json": _leaves(_control(folder))}
        run = read_run(folder / "bag")
        truth = read_truth(folder / "truth.csv", run)
        for page in figure_pages(run, truth):
            found[f"figure {page.name}"] = _drawn(page.figure)
        for index, table in enumerate(all_tables(run, truth)):
            cells = " ".join(" ".join(map(str, row)) for row in table.rows)
            found[f"table {index}"] = np.array([float(x.rstrip(".")) for x in NUMBER.findall(cells)])
    return found


def _control(folder: Path) -> dict:
    """control.json as the scenario writes it."""
    options = argparse.Namespace(duration=0.0, out=folder)
    return json.loads(json.dumps(Scenario(options).evaluate(folder)))


def _leaves(value) -> np.ndarray:
    def walk(one) -> Iterator[float]:
        if isinstance(one, dict):
            for key in sorted(one):
                yield from walk(one[key])
        elif isinstance(one, (list, tuple)):
            for item in one:
                yield from walk(item)
        elif one is None:
            yield np.nan
        elif not isinstance(one, str):
            yield float(one)

    return np.array(list(walk(value)))


def _drawn(figure) -> np.ndarray:
    """Data of all lines and bands, in data units."""
    parts = []
    for axes in figure.axes:
        for line in axes.get_lines():
            parts += [np.asarray(column, float).ravel() for column in line.get_data(orig=False)]
        for collection in axes.collections:
            parts += [path.vertices.ravel() for path in collection.get_paths()]
            parts.append(np.asarray(collection.get_offsets(), float).ravel())
    return np.concatenate(parts) if parts else np.zeros(0)
