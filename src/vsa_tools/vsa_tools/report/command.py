# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`report BAG`: the paper's figures and table from a recording, as HTML, PDF and PNG."""

import argparse
import gc
import platform
import sys
from collections.abc import Callable, Iterator
from datetime import datetime, timezone
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np
from vsa_common.figures import lay_out, save, save_pdf, text_page
from vsa_common.fork import ForkedTasks, ReportProgress
from vsa_common.io.bags import BagError
from vsa_common.io.tables import TableError
from vsa_common.terminal import progress
from vsa_estimator.offline.coefficient_file import (
    EXPONENTIAL_KNOTS,
    UNITS,
    NamedCoefficients,
    described,
    posterior_parameters,
    write_file,
)
from vsa_tools.report.columns import Series
from vsa_tools.report.data import Run, read_run
from vsa_tools.report.figures import figure_pages
from vsa_tools.report.page import page
from vsa_tools.report.tables import Table, health_table, joint_table, table_1
from vsa_tools.report.truth import Truths, read_truth

LIBRARIES = ("vsa_tools", "numpy", "scipy", "rosbags", "matplotlib")
STEPS = 3  # of the progress bar: read, draw, write
ATTACHMENTS = ("parameters.yaml", "summary.json")  # included in full if in the bag's folder or next to it


def main(args: list[str] | None = None) -> int:
    """Write the report of one bag; 1, with one line on stderr, on an error."""
    options = _parser().parse_args(args)
    gc.disable()  # a short process with millions of small tuples and no relevant cycles
    out = options.out or options.bag.resolve().parent
    try:
        with progress(STEPS, "reading the bag", count=True) as bar:
            where = write(options.bag, out, options.truth, on_step=lambda text: bar.advance(text=text))
    except (BagError, TableError, OSError) as error:
        print(f"report: {error}", file=sys.stderr)
        return 1
    print(f"wrote {where}, {where.with_suffix('.pdf')} and {out / 'figures'}/*.png")
    return 0


def write(
    bag: Path | str,
    out: Path | str,
    truth: Path | str | None = None,
    print_files: bool = True,
    on_step: Callable[[str], None] = lambda text: None,
) -> Path:
    """Write `out`/report.html, coefficients.yaml and, with `print_files`, report.pdf, figures/*.png; the page's path.

    `truth` is the CSV file of the simulated rig; default: truth.csv in the bag's folder or next to it, if present.
    `on_step` is called with the name of each step. Raises BagError or TableError where a file cannot be read.
    """
    run, out = read_run(Path(bag)), Path(out)
    found = Path(truth) if truth else next(_files_near(run.path, "truth.csv"), None)
    on_step("drawing")
    truths = read_truth(found, run) if found else {}
    pages, tables = list(figure_pages(run, truths)), list(all_tables(run, truths))
    for one in pages:
        lay_out(one.figure)
    out.mkdir(parents=True, exist_ok=True)
    title, lead, target = f"Impedance report: {run.path.resolve().name}", describe(run), out / "report.html"
    remarks = [*warnings(run), *([] if found is None else without_truth(run, truths))]

    def write_page() -> None:
        target.write_text(page(title, lead, remarks, tables, pages, _texts(run)), encoding="utf-8")
        write_coefficients(run, out / "coefficients.yaml")

    def write_pdf(_: ReportProgress) -> None:
        first = text_page(title, [lead, *remarks], [(one.title, [one.columns, *one.rows]) for one in tables])
        save_pdf([first, *(one.figure for one in pages)], out / "report.pdf")

    def write_pictures(_: ReportProgress) -> None:
        for one in pages:
            save(one.figure, out / "figures" / f"{one.name}.png")

    on_step("writing page, PDF and pictures")
    tasks = ForkedTasks(*([write_pdf, write_pictures] if print_files else []))
    write_page()
    tasks.results()
    return target


def write_coefficients(run: Run, path: Path) -> bool:
    """Write the coefficients at the end with covariance, start values of another run; whether a stiffness was valid.

    Without any there is no file at `path`.
    """
    sections: dict[str, object] = {}
    remarks: list[str] = []
    for joint in run.joints:
        for side in joint.transmissions:
            coefficients = last_coefficients(side.state) if side.state is not None else None
            if side.state is None or coefficients is None:
                continue
            node = f"{joint.name.rstrip('/')}/{side.name.replace('transmission', 'estimator')}"
            sections[node] = {"ros__parameters": {"initial": {"posterior": posterior_parameters(coefficients)}}}
            remarks += described(node, coefficients, f"{run.path.resolve().name}, {side.state.time[-1]:.1f} s")
    if sections:
        write_file(path, sections, remarks)
    else:
        path.unlink(missing_ok=True)  # of an earlier report
    return bool(sections)


def last_coefficients(state: Series) -> NamedCoefficients | None:
    """Coefficients of the last EstimatorState; None where its stiffness is not valid or its law not exponential."""
    names = tuple(UNITS)
    covariance = np.array([state[f"coefficient_covariance_{i + 1}"][-1] for i in range(len(names) ** 2)])
    values = tuple(float(state[name][-1]) for name in names)
    if len(state.flagged.get("elastic_deflection", ())) > EXPONENTIAL_KNOTS:
        return None
    if not state.valid("ln_stiffness_reference")[-1] or not np.isfinite([*covariance, *values]).all():
        return None
    matrix = covariance.reshape(len(names), len(names))
    return NamedCoefficients(names, values, matrix, float(state["deflection_reference"][-1]))


def all_tables(run: Run, truth: Truths) -> Iterator[Table]:
    """Table I, impedance and health of every joint, then the diagnostics above OK."""
    for joint in run.joints:
        several = f" ({joint.name})" if len(run.joints) > 1 else ""
        for table in (table_1(joint, truth), joint_table(joint), health_table(joint)):
            if table is not None and table.rows:
                yield Table(table.title + several, table.columns, table.rows, table.note)
    if run.diagnostics:
        rows = [[f"{d.first:.1f} s", d.node, _LEVELS.get(d.level, "?"), d.text, str(d.count)] for d in run.diagnostics]
        yield Table("Diagnostics above OK", ["first", "node", "level", "first text", "count"], rows)


_LEVELS = {1: "warning", 2: "error", 3: "stale"}


def describe(run: Run) -> str:
    """Begin, duration, number of messages and path on one line."""
    begun = datetime.fromtimestamp(run.start_ns * 1e-9, tz=timezone.utc)
    messages = sum(topic.messages for topic in run.topics.values())
    return f"{begun:%Y-%m-%d %H:%M:%S} UTC, {run.duration:.1f} s, {messages} messages, {run.path.resolve()}"


def warnings(run: Run) -> list[str]:
    """Warnings at the top of the report."""
    found = []
    if not run.complete:
        found.append("The recording was cut off; the report covers its readable part.")
    for joint in run.joints:
        for side in joint.transmissions:
            if side.impedance is None:
                found.append(f"{joint.name} {side.name}: no impedance recorded, sensors only.")
            elif not np.any(side.impedance.valid("stiffness")):
                found.append(f"{joint.name} {side.name}: stiffness is not valid at any time in this run.")
    return found


def without_truth(run: Run, truths: Truths) -> list[str]:
    """Warnings for the transmissions to which the truth of the simulated rig cannot be assigned."""
    return [
        f"{joint.name} {side.name}: without capture_counters the truth cannot be assigned to its samples."
        for joint in run.joints
        for side in joint.transmissions
        if (joint.name, side.name) not in truths
    ]


def _texts(run: Run) -> dict[str, str]:
    """Parameters, summary, recorded topics and versions in full."""
    found = {name: next(_files_near(run.path, name), None) for name in ATTACHMENTS}
    texts = {name: path.read_text(errors="replace") for name, path in found.items() if path}
    topics = sorted(run.topics.values(), key=lambda topic: topic.name)
    texts["recorded topics"] = "\n".join(f"{one.messages:9d}  {one.name}  {one.type_name}" for one in topics)
    return texts | {"versions": "\n".join(_versions())}


def _versions() -> Iterator[str]:
    for name in LIBRARIES:
        try:
            yield f"{name} {version(name)}"
        except PackageNotFoundError:
            continue
    yield f"Python {platform.python_version()} on {platform.platform()}"


def _files_near(bag: Path, name: str) -> Iterator[Path]:
    folder = bag if bag.is_dir() else bag.parent
    yield from (path for path in (folder / name, folder.resolve().parent / name) if path.is_file())


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="report", description=__doc__)
    parser.add_argument(
        "bag", type=Path, metavar="BAG", help="folder of a rosbag2 recording, or one .mcap or .db3 file"
    )
    text = "folder of report.html, report.pdf and figures/ (default: that of the bag)"
    parser.add_argument("--out", type=Path, metavar="DIR", help=text)
    text = "truth of the simulated rig (default: truth.csv in the bag or next to it, if present)"
    parser.add_argument("--truth", type=Path, metavar="CSV", help=text)
    return parser


if __name__ == "__main__":
    sys.exit(main())
