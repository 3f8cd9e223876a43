# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Comparison of the trials of a constant: flags, table, Markdown, JSON; and the command."""

import json
import subprocess
import sys
from dataclasses import replace

import pytest
from vsa_bench.ablation import command
from vsa_bench.ablation.figures import Figures, changes
from vsa_bench.ablation.report import (
    FAILS,
    HEADER,
    INSENSITIVE,
    NO_EFFECT,
    SENSITIVE_FLAG,
    Row,
    as_json,
    chosen,
    collect,
    effect,
    markdown,
    table,
)
from vsa_bench.ablation.trial import Trial
from vsa_bench.ablation.variation import DOUBLE, HALF, vary
from vsa_common.tuning import Constant

FIGURES = Figures(
    stiffness_nrmse=0.01, damping_nrmse=0.02, stiffness_coverage=0.95, damping_coverage=0.95, convergence_time_s=5.0,
    stiffness_valid=0.9, damping_valid=0.8, wrong=0.0, resets=0,
)  # fmt: skip
DURATION = {"case": 20.0}


def constant(value, name="GATE"):
    return Constant(name, value, "", -1e9, 1e9, "reason", "ablation")


def test_changes_are_relative_for_errors_and_absolute_for_shares():
    varied = replace(
        FIGURES, stiffness_nrmse=0.011, damping_nrmse=None, stiffness_coverage=0.9, convergence_time_s=7.0, resets=2
    )
    result = changes(FIGURES, varied, 20.0)
    assert result["stiffness_nrmse"] == pytest.approx(0.1)
    assert result["damping_nrmse"] == 1.0
    assert result["stiffness_coverage"] == pytest.approx(-0.05)
    assert result["convergence_time_s"] == pytest.approx(0.1)
    assert result["resets"] == 2
    assert result["wrong"] == result["damping_coverage"] == 0.0


def trial_of(digest="same", failure="", **changed):
    return Trial({"case": replace(FIGURES, **changed)}, {"case": digest}, failure)


def row_of(half, double):
    one = constant(3.0)
    effects = [
        effect(vary("tuning.filter", one, factor), trial_of(), varied, DURATION)
        for factor, varied in ((HALF, half), (DOUBLE, double))
    ]
    (row,) = collect({"tuning.filter": {"GATE": one}}, effects)
    return row


@pytest.mark.parametrize(
    ("half", "double", "flag"),
    [
        (trial_of(), trial_of(), NO_EFFECT),
        (trial_of(), trial_of("other"), INSENSITIVE),
        (trial_of(), trial_of("other", stiffness_nrmse=0.0102), INSENSITIVE),
        (trial_of("other", stiffness_nrmse=0.0104), trial_of(), SENSITIVE_FLAG),
        (trial_of(), trial_of("other", stiffness_valid=0.8), SENSITIVE_FLAG),
        (trial_of(), trial_of("other", resets=1), SENSITIVE_FLAG),
        (trial_of(), Trial({}, {}, "ZeroDivisionError: division by zero"), FAILS),
    ],
)
def test_the_flag_states_the_effect_of_a_constant(half, double, flag):
    row = row_of(half, double)
    assert row.flag == flag
    assert len(table([row])[0]) == len(HEADER)
    assert json.loads(json.dumps(as_json(row)))["flag"] == flag


def test_the_table_names_the_greatest_change_of_each_side():
    cells = table([row_of(trial_of("a", damping_nrmse=0.03, wrong=0.02), trial_of("b", stiffness_nrmse=0.009))])[0]
    assert cells[:5] == ["filter.GATE", "sensitive", "-", "3", ""]
    assert cells[5:] == ["+50.0 % damping", "-10.0 % stiffness", "+2.0 % wrong", "-"]


def test_a_constant_that_cannot_be_varied_has_no_effect():
    row = Row("tuning.filter", constant(0.0), None, None)
    assert row.flag == NO_EFFECT
    assert table([row])[0][5:] == ["-"] * 4


def test_the_markdown_has_one_table_for_each_module():
    first = row_of(trial_of(), trial_of("b", stiffness_nrmse=0.009))
    text = markdown([first, first._replace(module="tuning.output")], "Ablation")
    assert text.count("\n## tuning.") == 2
    assert text.count("| `GATE` | sensitive | - | 3 |") == 2
    assert len({line.count("|") for line in text.splitlines() if line.startswith("|")}) == 1


def test_constants_are_chosen_by_name_or_module():
    p, q = constant(1.0, name="P"), constant(1.0, name="Q")
    constants = {"a.tuning.x": {"P": p, "Q": q}, "a.tuning.y": {"P": p}}

    def names(*only):
        return [f"{module[-1]}.{one.name}" for module, one in chosen(constants, only)]

    assert names() == ["x.P", "x.Q", "y.P"]
    assert names("P") == ["x.P", "y.P"]
    assert names("y") == names("y.P") == ["y.P"]
    assert names("x.Q") == ["x.Q"]


def test_the_command_names_itself_and_refuses_unknown_constants(capsys):
    assert command.main(["--quick", "--only", "no_such_constant"]) == 1
    assert "no tuned constant of vsa_estimator is chosen" in capsys.readouterr().err
    text = subprocess.run(
        [sys.executable, "-m", "vsa_bench.ablation.command", "--help"], capture_output=True, text=True, check=True
    ).stdout
    assert "--markdown" in text
