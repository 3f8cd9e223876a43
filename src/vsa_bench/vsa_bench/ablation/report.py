# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Results of the ablation as records, table rows and Markdown."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any, NamedTuple

from vsa_bench.ablation.figures import ERRORS, changes
from vsa_bench.ablation.trial import Trial
from vsa_bench.ablation.variation import DOUBLE, HALF, Value, Variation
from vsa_common.tuning import Constant

SENSITIVE = 0.03  # least change of a figure that counts
NO_EFFECT, INSENSITIVE, SENSITIVE_FLAG, FAILS = "no effect", "insensitive", "sensitive", "fails"
HEADER = (
    "constant", "effect", "recordings", "value", "unit", "error at half", "error at double", "other at half",
    "other at double",
)  # fmt: skip
NOTE = (
    f"error: greatest change of the stiffness or damping error (NRMSE) over all recordings, in percent of that error. "
    f"other: greatest change of another figure: coverage, valid and wrong shares in percentage points, "
    f"convergence time in percent of the recording, resets. * the range of the constant does not permit the whole "
    f"factor. no effect: no output bit changes; insensitive: every change is below {100.0 * SENSITIVE:g} %."
)
LABELS = {
    "stiffness_nrmse": "stiffness", "damping_nrmse": "damping", "noise_error": "noise",
    "instant_error": "instant", "flagged": "flagged", "accepted": "accepted",
    "stiffness_coverage": "stiffness coverage", "damping_coverage": "damping coverage",
    "convergence_time_s": "convergence", "stiffness_valid": "stiffness valid", "damping_valid": "damping valid",
    "wrong": "wrong", "resets": "resets",
}  # fmt: skip


class Change(NamedTuple):
    """The greatest change of a group of figures: as a fraction, of which figure, on which recording."""

    change: float
    figure: str
    recording: str

    def __str__(self) -> str:
        """As a table shows it.

        >>> str(Change(0.123, "damping_nrmse", "T1 dwells"))
        '+12.3 % damping'
        """
        if self.figure == "resets":
            return f"{self.change:+.0f} resets"
        return f"{100.0 * self.change:+.1f} % {LABELS[self.figure]}" if self.figure else "-"


class Effect(NamedTuple):
    """Effect of one variation."""

    variation: Variation
    error: Change
    other: Change
    bits_changed: bool
    trial: Trial
    group: str = ""  # of the recordings


class Row(NamedTuple):
    """One constant with the effects of its half and of its double; None where its value does not change."""

    module: str
    constant: Constant
    half: Effect | None
    double: Effect | None

    @property
    def group(self) -> str:
        """The group of recordings on which the constant was varied."""
        return next((one.group for one in (self.half, self.double) if one), "")

    @property
    def flag(self) -> str:
        """The effect of the constant in a word."""
        effects = [one for one in (self.half, self.double) if one]
        if any(one.trial.failure for one in effects):
            return FAILS
        if not any(one.bits_changed for one in effects):
            return NO_EFFECT
        greatest = max(abs(change.change) for one in effects for change in (one.error, one.other))
        return SENSITIVE_FLAG if greatest >= SENSITIVE else INSENSITIVE


def effect(variation: Variation, base: Trial, varied: Trial, durations: Mapping[str, float]) -> Effect:
    """Compare the trial of a variation with that of the tuned values; `durations`: of the recordings [s]."""
    every = [
        Change(change, figure, name)
        for name, after in varied.figures.items()
        for figure, change in changes(base.figures[name], after, durations[name]).items()
    ]
    errors, others = ([one for one in every if (one.figure in ERRORS) == wanted] for wanted in (True, False))
    return Effect(variation, _greatest(errors), _greatest(others), varied.digests != base.digests, varied)


def collect(
    constants: Mapping[str, Mapping[str, Constant]], effects: Sequence[Effect], only: Sequence[str] = ()
) -> list[Row]:
    """One row for each constant, in the order of declaration; of those that `only` names, where it names any."""
    found = {(e.variation.module, e.variation.name, e.variation.factor): e for e in effects}
    return [
        Row(module, one, found.get((module, one.name, HALF)), found.get((module, one.name, DOUBLE)))
        for module, one in chosen(constants, only)
    ]


def chosen(constants: Mapping[str, Mapping[str, Constant]], only: Sequence[str]) -> Iterator[tuple[str, Constant]]:
    """Module and constant: all, or of those whose name, module or both are in `only`."""
    for module, members in constants.items():
        short = module.rpartition(".")[2]
        for one in members.values():
            if not only or {one.name, short, f"{short}.{one.name}", module} & set(only):
                yield module, one


def table(rows: Sequence[Row]) -> list[list[str]]:
    """Cells of the terminal table."""
    return [[f"{row.module.rpartition('.')[2]}.{row.constant.name}", row.flag, *_cells(row)] for row in rows]


def markdown(rows: Sequence[Row], heading: str) -> str:
    """The table with its explanation, one section for each module."""
    lines = [f"# {heading}", "", NOTE.replace("* the", "`*`: the"), ""]
    for module in dict.fromkeys(row.module for row in rows):
        lines += [f"## {module}", "", f"| {' | '.join(HEADER)} |", "|---" * len(HEADER) + "|"]
        for row in rows:
            if row.module == module:
                cells = [f"`{row.constant.name}`", row.flag, *_cells(row)]
                lines.append(f"| {' | '.join(cell.replace('*', '`*`') for cell in cells)} |")
        lines.append("")
    return "\n".join(lines)


def as_json(row: Row) -> dict[str, Any]:
    """A row with all figures of both trials."""
    return {
        "module": row.module,
        **row.constant._asdict(),
        "flag": row.flag,
        "group": row.group,
        "half": _effect_as_json(row.half),
        "double": _effect_as_json(row.double),
    }


def _effect_as_json(one: Effect | None) -> dict[str, Any] | None:
    if one is None:
        return None
    return {
        "value": one.variation.value,
        "clipped": one.variation.clipped,
        "bits_changed": one.bits_changed,
        "error": one.error._asdict(),
        "other": one.other._asdict(),
        "failure": one.trial.failure,
        "figures": {name: asdict(figures) for name, figures in one.trial.figures.items()},
    }


def _cells(row: Row) -> list[str]:
    sides = (row.half, row.double)
    return [row.group or "-", _text(row.constant.value), row.constant.unit, *map(_error, sides), *map(_other, sides)]


def _error(one: Effect | None) -> str:
    if one is None:
        return "-"
    text = "fails" if one.trial.failure else "0" if not one.bits_changed else str(one.error)
    return text + " *" * one.variation.clipped


def _other(one: Effect | None) -> str:
    return "-" if one is None or not one.other.change else str(one.other)


def _greatest(every: Sequence[Change]) -> Change:
    return max(every, key=lambda one: abs(one.change), default=Change(0.0, "", ""))


def _text(value: Value) -> str:
    return ", ".join(f"{one:g}" for one in value) if isinstance(value, tuple) else f"{value:g}"
