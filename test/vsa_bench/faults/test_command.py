# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The estimator on faulty and healthy recordings, the summary of the runs, and the command."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from vsa_bench.faults import command, run
from vsa_bench.faults.cases import FaultCase, HealthyCase
from vsa_bench.faults.hypotheses import SATURATION
from vsa_bench.faults.injection import BEGIN_S
from vsa_bench.faults.observation import observe
from vsa_bench.faults.run import healthy_figures, run_fault
from vsa_bench.faults.summary import bars, fault_figures
from vsa_bench.faults.summary import healthy_figures as summarised
from vsa_bench.faults.table import pages
from vsa_bench.mismatch.run import estimate, start_parameters
from vsa_common.types import Status
from vsa_simulator.rig.motion import Tone, tones
from vsa_simulator.rig.recording import Simulation, TransmissionVariant

SATURATED, NOISY = "force sensor saturated", "force sensor noisy: several times the configured noise"


def fault_run(**changes):
    run = {
        "fault": "force_stuck", "form": "2 s", "motion": "mix", "rate_hz": 100, "seed": 1, "expected": "force stuck",
        "valid_before": True, "detected_after_s": 0.2, "named": "force stuck", "named_after_s": 0.2, "wrong_s": 0.0,
        "longest_wrong_s": 0.0, "time_to_valid_s": 0.5,
    }  # fmt: skip
    return run | changes


def healthy_run(**changes):
    run = {
        "transmission": "paper_1", "motion": "mix", "stamps": "exact", "rate_hz": 100, "seed": 1, "hours": 2.0,
        "alarms": [], "correct_reports": 0, "valid": 1.0, "wrong": 0.0,
    }  # fmt: skip
    return run | changes


def test_a_stuck_encoder_is_detected_named_and_its_figures_are_complete():
    figures = run_fault(FaultCase("encoder_stuck", 2.0, "mix", 100), 5)
    assert figures["valid_before"]
    assert 0.0 < figures["detected_after_s"] <= figures["named_after_s"] < 1.0
    assert figures["named"] == figures["expected"] == "encoder stuck"
    assert figures["longest_wrong_s"] <= figures["wrong_s"]
    json.dumps(figures, allow_nan=False)


@pytest.mark.parametrize(
    ("duration", "reports", "expected"),
    [
        (math.inf, [], None),
        (2.0, [], 0.0),
        (math.inf, [(BEGIN_S + 5.0, frozenset({"encoder stuck"}))], 1.0),
    ],
    ids=["lasting, not detected", "transient, not detected", "lasting, detected"],
)
def test_the_recovery_from_a_lasting_fault_counts_from_its_detection(monkeypatch, duration, reports, expected):
    time = np.arange(0.0, 60.0, 0.01)
    valid = (time < BEGIN_S + 4.0) | (time >= BEGIN_S + 6.0)
    valid |= not reports
    seen = SimpleNamespace(time=time, valid=valid, reports=reports, wrong=lambda stiffness: time < 0.0)
    monkeypatch.setattr(run, "faulty", lambda *_: (None, None, None))
    monkeypatch.setattr(run, "observe", lambda *_: seen)
    figures = run_fault(FaultCase("encoder_stuck", duration, "mix", 100), 5)
    assert figures["time_to_valid_s"] == (expected if expected is None else pytest.approx(expected))


def test_an_observation_has_the_estimates_of_the_estimator():
    simulation = Simulation(TransmissionVariant(), tones(0.0095, Tone(0.003, 0.2)), 8.0, 100)
    recording, start = simulation.recording(1), start_parameters(simulation, 1)
    seen, rows = observe(recording, start, 0.05, 100), estimate(recording, start)
    used = np.isfinite(rows["status"])
    np.testing.assert_array_equal(seen.rows, rows[used])
    np.testing.assert_array_equal(seen.degraded, rows["status"][used] == Status.DEGRADED)
    figures = healthy_figures(seen, simulation.stiffness, 6.0, frozenset())
    assert figures["hours"] == pytest.approx(2.0 / 3600.0, rel=0.02)


def test_a_report_of_what_is_true_is_no_false_alarm():
    time = np.arange(0.0, 20.0, 0.01)
    seen = SimpleNamespace(
        time=time, valid=time >= 0.0, wrong=lambda stiffness: time < 0.0, fault_resets=time < 0.0,
        degraded=(time > 8.0) & (time < 9.0) | (time > 15.0), reports=[(8.1, {SATURATED}), (15.1, {SATURATED, NOISY})],
    )  # fmt: skip
    for correct, alarms, reports in ((frozenset(), 2, 0), (frozenset({SATURATION}), 1, 1)):
        figures = healthy_figures(seen, time, 6.0, correct)
        assert (len(figures["alarms"]), figures["correct_reports"]) == (alarms, reports)


def test_figures_are_medians_and_the_worst_of_runs_with_valid_stiffness_before_the_fault():
    runs = [
        fault_run(),
        fault_run(detected_after_s=0.4, named="encoder stuck", longest_wrong_s=0.3, wrong_s=0.6, time_to_valid_s=4.0),
        fault_run(detected_after_s=None, named="not detected", time_to_valid_s=None),
        fault_run(valid_before=False, longest_wrong_s=9.0),
    ]
    figures = fault_figures(runs)
    assert figures == (3, pytest.approx(2 / 3), 0.4, math.inf, pytest.approx(1 / 3), 0.0, 0.3, 4.0, math.inf)


def test_the_rate_of_false_alarms_and_the_shares_are_weighted_by_hours():
    alarm = {"at_s": 7.0, "texts": ["encoder stuck"]}
    figures = summarised([healthy_run(), healthy_run(hours=6.0, alarms=[alarm, alarm], valid=0.8)])
    assert (figures.hours, figures.alarms, figures.rate) == (8.0, 2, 0.25)
    assert figures.low < 0.25 < figures.high
    assert figures.valid == pytest.approx(0.85)


def test_required_figures_are_reached_or_missed():
    reached = {one.quantity: one.reached for one in bars([fault_run()], [healthy_run()])}
    assert len(reached) == 6
    assert all(reached.values())
    missed = bars(
        [fault_run(longest_wrong_s=0.2, time_to_valid_s=3.5)],
        [healthy_run(alarms=[{"at_s": 7.0, "texts": []}], valid=0.9, wrong=0.01)],
    )
    assert not any(one.reached for one in missed)
    assert list(bars([], [])) == []


def test_the_isolation_table_has_a_column_for_each_named_hypothesis():
    runs = [fault_run(), fault_run(named="encoder stuck"), fault_run(fault="stamps_late", expected="stamps late")]
    (page,) = (one for one in pages({"faults": runs, "healthy": []}) if one.title == "isolation")
    assert page.header == ("fault", "expected", "force stuck", "encoder stuck")
    assert page.rows == [["force_stuck", "force stuck", "1", "1"], ["stamps_late", "stamps late", "1", ""]]


def test_the_command_writes_the_runs_and_prints_the_same_tables_from_its_file(tmp_path, capsys):
    path = tmp_path / "folder" / "f.json"
    choice = ["--case", "encoder_stuck", "exact", "--motion", "mix", "--rate", "100", "--quick"]
    arguments = [*choice, "--seed", "5", "--hours", "0.004", "--workers", "2"]
    assert command.main([*arguments, "--json", str(path), "--markdown"]) == 0
    printed = capsys.readouterr().out
    report = json.loads(path.read_text())
    assert [(one["fault"], one["form"]) for one in report["faults"]] == [
        ("encoder_stuck", "lasting"), ("encoder_stuck", "2 s")
    ]  # fmt: skip
    assert [one["stamps"] for one in report["healthy"]] == ["exact"]
    assert "### Isolation" in printed
    assert "### Required figures" in printed
    assert command.main(["--from", str(path), "--markdown"]) == 0
    assert capsys.readouterr().out == printed


def test_a_choice_without_a_case_is_an_error(capsys):
    assert command.main(["--quick", "--case", "force_stuck", "--rate", "1000"]) == 1
    assert "no case has the given" in capsys.readouterr().err


def test_a_failure_names_its_run():
    def fail():
        raise ValueError("no estimate")

    label = HealthyCase("paper_1", "mix", "exact", 100).label
    with pytest.raises(RuntimeError, match="paper_1 mix, exact stamps, 100 Hz: ValueError"):
        command._run_one((label, fail))
