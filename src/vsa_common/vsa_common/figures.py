# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Figures in the style of the suite, drawn by matplotlib without a display; it is loaded with the first figure.

>>> figure, (top, bottom) = panels(2)
>>> line = top.plot([0.0, 1.0], [2.0, 3.0], color=SIDE_1)
>>> save(figure, "two.png")  # doctest: +SKIP
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito's palette: distinguishable with colour vision deficiency.
SIDE_1 = "#0072b2"
SIDE_2 = "#d55e00"
JOINT = "#00856a"
TRUTH = "#222222"
MEASURED = "#999999"
WARNING = "#cc79a7"
SIDES = (SIDE_1, SIDE_2)

BAND_ALPHA = 0.22
WIDTH = 8.0  # [inch]

STYLE = {
    "font.family": "sans-serif",
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.1,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "savefig.dpi": 130,
    "svg.fonttype": "none",  # text as text, not as paths: small, searchable, in the page's font
    "svg.hashsalt": "vsa",  # reproducible files
    "path.simplify_threshold": 0.3,
}


def panels(
    rows: int = 1,
    columns: int = 1,
    *,
    height: float | None = None,
    width: float = WIDTH,
    title: str = "",
) -> tuple[Figure, Any]:
    """A figure and its axes: one, an array of them, or a matrix, as `Figure.subplots` returns them; sizes in inches."""
    figure = _figure(width, 1.75 * rows + 0.6 if height is None else height, layout="constrained")
    axes = figure.subplots(rows, columns)
    if title:
        set_title(figure, title)
    return figure, axes


def stack(rows: int, *, height: float, duration: float, width: float = WIDTH) -> tuple[Figure, list[Axes]]:
    """Panels above each other over a time axis of `duration` [s], `height` inches each; fixed margins."""
    tall = rows * height + 0.8
    figure = _figure(width, tall)
    margins = {"left": 0.85 / width, "right": 1.0 - 0.15 / width, "bottom": 0.45 / tall, "top": 1.0 - 0.4 / tall}
    axes = list(figure.subplots(rows, sharex=True, squeeze=False, gridspec_kw={**margins, "hspace": 0.14})[:, 0])
    for one in axes:
        one.yaxis.set_label_coords(-0.65 / (width - 1.0), 0.5)
    axes[-1].set(xlabel="time [s]", xlim=(0.0, duration or 1.0))
    return figure, axes


def set_title(figure: Figure, title: str) -> None:
    """Title of the figure."""
    above = {} if figure.get_layout_engine() else {"y": 1.0 - 0.08 / figure.get_figheight(), "va": "top"}
    figure.suptitle(title, x=0.01, ha="left", weight="bold", size=11, **above)


def band(axes: Axes, x: Any, low: Any, high: Any, color: str) -> None:
    """The interval of a quantity, shaded between `low` and `high`."""
    axes.fill_between(x, low, high, color=color, alpha=BAND_ALPHA, linewidth=0.0)


def limits(axes: Axes, *series: Any, margin: float = 0.08, tail: float = 0.005) -> None:
    """Fit the y axis to `series` without the fraction `tail` of extremes at each end; NaN is skipped."""
    values = np.concatenate([np.ravel(np.asarray(one, dtype=float)) for one in series])
    values = values[np.isfinite(values)]
    if len(values):
        low, high = np.quantile(values, [tail, 1.0 - tail])
        room = margin * (high - low) or 0.1 * abs(high) or 1.0
        axes.set_ylim(low - room, high + room)


def text_page(title: str, lines: Sequence[str], tables: Sequence[tuple[str, Sequence[Sequence[str]]]]) -> Figure:
    """A page of a PDF: title, lines of text, and tables (heading, rows); a table's first row has the column names."""
    height = 1.2 + 0.2 * len(lines) + sum(0.6 + 0.17 * len(rows) for _, rows in tables)
    figure = _figure(WIDTH, height)
    y = 1.0 - 0.4 / height
    figure.text(0.03, y, title, size=15, weight="bold")
    for line in lines:
        y -= 0.2 / height
        figure.text(0.03, y, line, size=7)
    for heading, rows in tables:
        y -= 0.4 / height
        figure.text(0.03, y, heading, size=10, weight="bold")
        y = _table(figure, rows, y - 0.05 / height, 0.17 / height) - 0.1 / height
    return figure


def lay_out(figure: Figure) -> None:
    """Run the layout engine once, for all files that the figure is written to."""
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine(None)  # the string "none" leaves a placeholder engine that draws each file twice


def _figure(width: float, height: float, layout: Literal["constrained"] | None = None) -> Figure:
    """An empty figure in the style, sizes in inches."""
    import matplotlib  # takes half a second, which no --help and no table needs
    from matplotlib.figure import Figure

    matplotlib.rcParams.update(STYLE)
    return Figure(figsize=(width, height), layout=layout)


def _table(figure: Figure, rows: Sequence[Sequence[str]], y: float, step: float) -> float:
    """Draw a table from `y` downwards, each column as wide as its longest cell; returns the y of its end."""
    widths = [max(len(row[i]) for row in rows) + 2 for i in range(len(rows[0]))]
    scale = min(0.94 / sum(widths), 0.012)
    for n, row in enumerate(rows):
        y -= step
        for i, cell in enumerate(row):
            x = 0.03 + scale * sum(widths[:i])
            figure.text(x, y, cell, size=min(7.5, 640.0 * scale), weight="bold" if n == 0 else "normal")
    return y


def save(figure: Figure, path: str | Path) -> None:
    """Write the figure in the format of the suffix (png, svg, pdf); creates the folder."""
    lay_out(figure)
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, metadata={"Date": None} if Path(path).suffix == ".svg" else None)


def save_pdf(figures: Iterable[Figure], path: str | Path) -> None:
    """Write one PDF with one figure on each page; creates the folder."""
    from matplotlib.backends.backend_pdf import PdfPages  # takes half a second, which other formats do not need

    Path(path).parent.mkdir(parents=True, exist_ok=True)
    with PdfPages(path) as pages:
        for figure in figures:
            lay_out(figure)
            pages.savefig(figure)


def inline_svg(figure: Figure, name: str) -> str:
    """The figure as an <svg> element for an HTML page; `name` makes its ids unique in the page."""
    import matplotlib

    lay_out(figure)
    buffer = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": name}):
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    return re.sub(r'<g id="[^"]*"', "<g", text)
