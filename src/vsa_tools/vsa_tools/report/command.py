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
from vsa_tools.report.data import Run, read_run
from vsa_tools.report.figures import figure_pages
from vsa_tools.report.page import page
from vsa_tools.report.tables import Table, health_table, joint_table, table_1
from vsa_tools.report.truth import Truths, read_truth

LIBRARIES = ("vsa_tools", "numpy", "scipy", "rosbags", "matplotlib")
STEPS = 3  # reading, drawing, writing
BESIDE = ("parameters.yaml", "summary.json")  # shown in full where they lie in the bag or beside it


def main(args: list[str] | None = None) -> int:
    """Write the report of one bag; 1 with one line on stderr where it cannot."""
    options = _parser().parse_args(args)
    gc.disable()  # a short life with millions of small tuples and no cycle worth a search
    out = options.out or options.bag.resolve().parent
    try:
        with progress(STEPS, "reading the bag", count=True) as bar:
            where = write(options.bag, out, options.truth, tell=lambda text: bar.advance(text=text))
    except (BagError, TableError, OSError) as error:
        print(f"report: {error}", file=sys.stderr)
        return 1
    print(f"wrote {where}, {where.with_suffix('.pdf')} and {out / 'figures'}/*.png")
    return 0


def write(
    bag: Path | str,
    out: Path | str,
    truth: Path | str | None = None,
    prints: bool = True,
    tell: Callable[[str], None] = lambda text: None,
) -> Path:
    """Write `out`/report.html and, as `prints`, report.pdf and figures/*.png of a bag; returns the path of the page.

    `truth` is the CSV file of the simulated rig; without it, truth.csv is taken where it lies in the bag or beside it.
    `tell` hears what comes next. Raises BagError or TableError with one line where there is nothing to report.
    """
    run, out = read_run(Path(bag)), Path(out)
    found = Path(truth) if truth else next(_beside(run.path, "truth.csv"), None)
    tell("drawing")
    known = read_truth(found, run) if found else {}
    drawn, tables = list(figure_pages(run, known)), list(all_tables(run, known))
    for plate in drawn:
        lay_out(plate.figure)
    out.mkdir(parents=True, exist_ok=True)
    title, lead = f"Impedance report: {run.path.resolve().name}", describe(run)
    target = out / "report.html"

    def write_page() -> None:
        target.write_text(page(title, lead, warnings(run), tables, drawn, _texts(run)), encoding="utf-8")

    def write_pdf(_: ReportProgress) -> None:
        first = text_page(title, [lead, *warnings(run)], [(one.title, [one.columns, *one.rows]) for one in tables])
        save_pdf([first, *(plate.figure for plate in drawn)], out / "report.pdf")

    def write_pictures(_: ReportProgress) -> None:
        for plate in drawn:
            save(plate.figure, out / "figures" / f"{plate.name}.png")

    tell("writing page, PDF and pictures")
    beside = ForkedTasks(*([write_pdf, write_pictures] if prints else []))
    write_page()
    beside.results()
    return target


def all_tables(run: Run, truth: Truths) -> Iterator[Table]:
    """Table I, the joint and the health of every joint, then what was said on /diagnostics."""
    for joint in run.joints:
        several = f" ({joint.name})" if len(run.joints) > 1 else ""
        for table in (table_1(joint, truth), joint_table(joint), health_table(joint)):
            if table is not None and table.rows:
                yield Table(table.title + several, table.columns, table.rows, table.note)
    if run.complaints:
        rows = [[f"{c.first:.1f} s", c.node, _LEVELS.get(c.level, "?"), c.text, str(c.count)] for c in run.complaints]
        yield Table("What the nodes complained of", ["first", "node", "level", "as said first", "times"], rows)


_LEVELS = {1: "warning", 2: "error", 3: "stale"}


def describe(run: Run) -> str:
    """When and how long, in one line."""
    begun = datetime.fromtimestamp(run.start_ns * 1e-9, tz=timezone.utc)
    messages = sum(topic.messages for topic in run.topics.values())
    return f"{begun:%Y-%m-%d %H:%M:%S} UTC, {run.duration:.1f} s, {messages} messages, {run.path.resolve()}"


def warnings(run: Run) -> list[str]:
    """What a reader must know before anything else."""
    found = []
    if not run.complete:
        found.append("The recording was cut off; this is the part that can be read.")
    for joint in run.joints:
        for side in joint.sides:
            if side.impedance is None:
                found.append(f"{joint.name} {side.name}: no impedance was recorded, sensors only.")
            elif not np.any(side.impedance.valid("stiffness")):
                found.append(f"{joint.name} {side.name}: stiffness was never valid in this run.")
    return found


def _texts(run: Run) -> dict[str, str]:
    """Parameters, recorded topics and versions, in full."""
    found = {name: next(_beside(run.path, name), None) for name in BESIDE}
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


def _beside(bag: Path, name: str) -> Iterator[Path]:
    folder = bag if bag.is_dir() else bag.parent
    yield from (path for path in (folder / name, folder.resolve().parent / name) if path.is_file())


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="report", description=__doc__)
    parser.add_argument(
        "bag", type=Path, metavar="BAG", help="folder of a rosbag2 recording, or one .mcap or .db3 file"
    )
    text = "where report.html, report.pdf and figures/ go (default: beside the bag)"
    parser.add_argument("--out", type=Path, metavar="DIR", help=text)
    text = "truth of the simulated rig (default: truth.csv in or beside the bag, if there)"
    parser.add_argument("--truth", type=Path, metavar="CSV", help=text)
    return parser


if __name__ == "__main__":
    sys.exit(main())
