# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""A report as one self-contained HTML page."""

from collections.abc import Mapping, Sequence
from html import escape

from vsa_common.figures import inline_svg
from vsa_tools.report.figures import FigurePage
from vsa_tools.report.tables import Table

WIDE = 40  # characters; a longer cell of a table wraps
STYLE = """
:root { --ink:#1c2733; --soft:#5b6b7a; --line:#e1e6eb; --ground:#f6f8fa; --card:#fff; --accent:#0072b2; --bad:#b3261e; }
@media (prefers-color-scheme: dark) {
  :root { --ink:#e4eaf0; --soft:#94a3b1; --line:#2c3843; --ground:#11181f; --card:#1a232c; --accent:#62b1e4;
    --bad:#ff8a80; }
  figure svg { filter: invert(0.9) hue-rotate(180deg); }
}
* { box-sizing: border-box; }
body { margin:0; background:var(--ground); color:var(--ink); font:15px/1.5 system-ui,"Segoe UI",Roboto,sans-serif; }
main { max-width:1060px; margin:0 auto; padding:24px 16px 64px; }
h1 { font-size:26px; margin:8px 0 4px; } h2 { font-size:18px; margin:0 0 10px; }
.lead { color:var(--soft); margin:0 0 18px; }
.warn { color:var(--bad); font-weight:600; }
nav { display:flex; flex-wrap:wrap; gap:6px; margin:0 0 20px; }
nav a { color:var(--accent); text-decoration:none; border:1px solid var(--line); background:var(--card);
  border-radius:14px; padding:2px 11px; font-size:13px; }
section { background:var(--card); border:1px solid var(--line); border-radius:10px; padding:18px; margin:0 0 18px; }
.scroll { overflow-x:auto; }
table { border-collapse:collapse; width:100%; font-size:13.5px; font-variant-numeric:tabular-nums; }
th,td { text-align:left; padding:5px 12px 5px 0; border-bottom:1px solid var(--line); white-space:nowrap; }
th { color:var(--soft); font-weight:600; } td.wide { white-space:normal; min-width:20em; }
figure { margin:0; } figure svg { width:100%; height:auto; display:block; }
figcaption,.note { color:var(--soft); font-size:13px; margin-top:8px; }
pre { overflow-x:auto; font-size:12.5px; background:var(--ground); padding:12px; border-radius:6px; margin:0; }
details summary { cursor:pointer; color:var(--accent); }
@media print { section { break-inside:avoid; border:none; padding:0; } nav { display:none; } body { background:#fff; } }
"""


def page(
    title: str,
    lead: str,
    warnings: Sequence[str],
    tables: Sequence[Table],
    figures: Sequence[FigurePage],
    texts: Mapping[str, str],
) -> str:
    """The HTML page; it has no external resources."""
    parts = [_table(table, f"table_{i}") for i, table in enumerate(tables)]
    parts += [_figure(one) for one in figures]
    parts += [_text(name, text) for name, text in texts.items()]
    links = "".join(f'<a href="#{one.name}">{escape(_short(one.title))}</a>' for one in figures)
    alarms = "".join(f'<p class="warn">{escape(warning)}</p>' for warning in warnings)
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{STYLE}</style></head><body><main>"
        f'<h1>{escape(title)}</h1><p class="lead">{escape(lead)}</p>{alarms}<nav>{links}</nav>'
        + "\n".join(parts)
        + "</main></body></html>\n"
    )


def _short(title: str) -> str:
    """Title of a link: the part before the colon, and the number of the transmission."""
    head, _, rest = title.partition(":")
    return f"{head}, {rest[-1]}" if rest[:-1].endswith("transmission_") else head


def _table(table: Table, anchor: str) -> str:
    head = "".join(f"<th>{escape(column)}</th>" for column in table.columns)
    rows = "".join("<tr>" + "".join(_cell(cell) for cell in row) + "</tr>" for row in table.rows)
    note = f'<p class="note">{escape(table.note)}</p>' if table.note else ""
    return (
        f'<section id="{anchor}"><h2>{escape(table.title)}</h2><div class="scroll"><table>'
        f"<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>{note}</section>"
    )


def _cell(text: str) -> str:
    wide = ' class="wide"' if len(text) > WIDE else ""
    return f"<td{wide}>{escape(text)}</td>"


def _figure(one: FigurePage) -> str:
    return (
        f'<section id="{one.name}" aria-label="{escape(one.title)}"><figure>{inline_svg(one.figure, one.name)}'
        f"<figcaption>{escape(one.caption)}</figcaption></figure></section>"
    )


def _text(name: str, text: str) -> str:
    body = f"<details><summary>{escape(name)}</summary><pre>{escape(text)}</pre></details>"
    return f"<section>{body}</section>"
