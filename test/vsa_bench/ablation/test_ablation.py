"""Variations of tuned constants, their application to a package, and the comparison of their trials."""

import importlib
import json
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import numpy as np
import pytest
from vsa_bench.ablation import command, trial
from vsa_bench.ablation.figures import Figures, changes, figures
from vsa_bench.ablation.recordings import FAULTS, simulated, with_sensor_faults
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
from vsa_bench.ablation.trial import Trial, import_anew, initialize_worker, run_trial
from vsa_bench.ablation.variation import DOUBLE, HALF, declared, vary
from vsa_bench.estimation.cases import case
from vsa_common.tuning import CONSTANTS, OVERRIDES, Constant

FIGURES = Figures(0.01, 0.02, 0.95, 0.95, 5.0, 0.9, 0.8, 0.0, 0)
DURATION = {"case": 20.0}


def constant(value, low=-1e9, high=1e9, name="GATE"):
    return Constant(name, value, "", low, high, "reason", "ablation")


def value(one, factor):
    varied = vary("filter", one, factor)
    return varied and (varied.value, varied.clipped)


@pytest.mark.parametrize(
    ("tuned", "half", "double"),
    [
        (3.0, 1.5, 6.0),
        (-4.0, -2.0, -8.0),
        (5, 3, 10),
        (1, None, 2),
        (0.0, None, None),
        ((1.0, 4.0), (0.5, 2.0), (2.0, 8.0)),
    ],
)
def test_a_constant_is_halved_and_doubled_in_its_own_type(tuned, half, double):
    for factor, expected in ((HALF, half), (DOUBLE, double)):
        varied = vary("filter", constant(tuned), factor)
        assert (varied and varied.value) == expected
        assert varied is None or type(varied.value) is type(tuned)


def test_a_value_out_of_range_is_clipped_and_marked():
    assert value(constant(3.0, 2.0, 5.0), HALF) == (2.0, True)
    assert value(constant(3.0, 2.0, 5.0), DOUBLE) == (5.0, True)
    assert value(constant(5, 1, 8), DOUBLE) == (8, True)
    assert value(constant(3.0, 3.0, 6.0), HALF) is None
    assert value(constant(3.0, 3.0, 6.0), DOUBLE) == (6.0, False)
    assert value(constant(-4.0, -5.0, -1.0), DOUBLE) == (-5.0, True)


def test_a_tuple_keeps_its_ratios_where_its_range_clips_it():
    assert value(constant((1.0, 4.0), 0.0, 6.0), DOUBLE) == ((1.5, 6.0), True)


@pytest.fixture
def tuned_package(tmp_path, monkeypatch):
    """A package with two constants; one of them determines another that is computed at import."""
    package = tmp_path / "tuned_sample"
    (package / "tuning").mkdir(parents=True)
    (package / "__init__.py").write_text("")
    (package / "tuning" / "__init__.py").write_text("")
    (package / "tuning" / "filter.py").write_text(
        "from vsa_common.tuning import constant\n"
        'GATE = constant("GATE", 3.0, "", 1.0, 10.0, "outliers", "ablation", module=__name__)\n'
        'SPARE = constant("SPARE", 7, "", 1, 100, "none", "ablation", module=__name__)\n'
    )
    (package / "model.py").write_text("from tuned_sample.tuning.filter import GATE\nLIMIT = GATE**2\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    yield "tuned_sample"
    import_anew("tuned_sample", {})
    assert not OVERRIDES


def test_constants_of_all_tuning_modules_are_found(tuned_package):
    assert {module: list(members) for module, members in declared(tuned_package).items()} == {
        "tuned_sample.tuning.filter": ["GATE", "SPARE"]
    }
    assert declared("vsa_msgs") == {}


def test_an_override_applies_to_the_constant_and_to_what_is_computed_from_it(tuned_package):
    module = "tuned_sample.tuning.filter"
    for overrides, gate in (({}, 3.0), ({(module, "GATE"): 6.0}, 6.0), ({(module, "SPARE"): 3}, 3.0), ({}, 3.0)):
        import_anew(tuned_package, overrides)
        model = importlib.import_module("tuned_sample.model")
        assert (gate, gate**2) == (model.GATE, model.LIMIT)
        assert CONSTANTS[module]["GATE"].value == gate


def test_an_override_out_of_range_is_refused(tuned_package):
    import_anew(tuned_package, {("tuned_sample.tuning.filter", "GATE"): 11.0})
    with pytest.raises(ValueError, match=r"GATE = 11\.0 : must be within 1 to 10"):
        importlib.import_module("tuned_sample.model")


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
    assert cells[:4] == ["filter.GATE", "sensitive", "3", ""]
    assert cells[4:] == ["+50.0 % damping", "-10.0 % stiffness", "+2.0 % wrong", "-"]


def test_a_constant_that_cannot_be_varied_has_no_effect():
    row = Row("tuning.filter", constant(0.0), None, None)
    assert row.flag == NO_EFFECT
    assert table([row])[0][4:] == ["-"] * 4


def test_the_markdown_has_one_table_for_each_module():
    first = row_of(trial_of(), trial_of("b", stiffness_nrmse=0.009))
    text = markdown([first, first._replace(module="tuning.output")], "Ablation")
    assert text.count("\n## tuning.") == 2
    assert text.count("| `GATE` | sensitive | 3 |") == 2
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


@pytest.fixture(scope="module")
def multisine():
    return simulated(case(motion="multisine", start="good"), "force", 6.0)


def test_figures_of_the_truth_are_without_error(multisine):
    ones = np.ones(len(multisine.force))
    estimates = {"stiffness": multisine.stiffness, "damping": multisine.damping}
    estimates |= {f"{name}_{part}": ones for name in ("stiffness", "damping") for part in ("valid", "variance")}
    assert figures(multisine, estimates, 0) == Figures(0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0)
    dropped = {name: np.where(np.arange(ones.size) % 2, values, np.nan) for name, values in estimates.items()}
    assert figures(multisine, dropped, 0) == Figures(0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0)
    wrong = figures(multisine, estimates | {"stiffness": 1.1 * multisine.stiffness, "stiffness_variance": ones}, 3)
    assert wrong.stiffness_nrmse == pytest.approx(0.1)
    assert (wrong.wrong, wrong.stiffness_coverage, wrong.convergence_time_s, wrong.resets) == (1.0, 0.0, None, 3)


def test_sensor_faults_leave_stamps_ordered_and_the_truth_aligned(multisine):
    faulty = with_sensor_faults(multisine)
    assert faulty.name == FAULTS
    assert (np.diff(faulty.stamps_ns) >= 0).all()
    received = np.isin(multisine.stiffness, faulty.stiffness)
    assert received.sum() == len(faulty.stiffness) < len(received)
    after_step = (np.arange(len(received)) > 0.8 * len(received))[received]
    assert (faulty.deflection - multisine.deflection[received])[after_step] == pytest.approx(1e-3)


def in_worker(recordings, *overrides):
    with ProcessPoolExecutor(1, get_context("fork"), initialize_worker, (recordings,)) as pool:
        return list(pool.map(run_trial, overrides))


def test_a_trial_runs_in_plain_python_and_repeats_to_the_bit(multisine):
    first, second = in_worker([multisine], {}, {})
    assert first.failure == ""
    assert first == second
    assert first.figures[multisine.name].stiffness_nrmse < 0.2
    assert trial.OVERRIDES == {}


def test_a_constant_of_the_estimator_changes_its_outputs(multisine):
    constants = {
        (module, one.name): vary(module, one, HALF)
        for module, one in chosen(declared(trial.PACKAGE), ())
        if "GATE" in one.name and ".filter" in module
    }
    if not constants:
        pytest.skip("no gate is declared in the tuning modules")
    faulty = with_sensor_faults(multisine)
    base, *varied = in_worker([faulty], {}, *(one.overrides for one in constants.values() if one))
    assert any(one.digests != base.digests for one in varied)


def test_the_command_names_itself_and_refuses_unknown_constants(capsys):
    assert command.main(["--quick", "--only", "no_such_constant"]) == 1
    assert "no tuned constant of vsa_estimator is chosen" in capsys.readouterr().err
    text = subprocess.run(
        [sys.executable, "-m", "vsa_bench.ablation.command", "--help"], capture_output=True, text=True, check=True
    ).stdout
    assert "--markdown" in text
