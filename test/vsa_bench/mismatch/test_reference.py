# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Local regression against analytic springs; real recordings from files."""

import numpy as np
import pytest
from vsa_bench.mismatch.recorded import MIN_SAMPLES, compare, compare_all
from vsa_bench.mismatch.reference import local_slopes
from vsa_common.io.tables import write_columns

RATE = 200.0
TIME = np.arange(0.0, 24.0, 1.0 / RATE)
PHASE = 2.0 * np.pi * 0.5 * TIME
DEFLECTION = 0.010 + 0.003 * np.sin(PHASE) + 0.0004 * np.sin(4.3 * PHASE)
VELOCITY = np.gradient(DEFLECTION, TIME)
K0, RATE_OF_SINH = 900.0, 220.0
STIFFNESS = K0 * np.cosh(RATE_OF_SINH * DEFLECTION)


def sinh_force(deflection):
    return 12.0 + K0 / RATE_OF_SINH * np.sinh(RATE_OF_SINH * deflection)


def errors(force, deflection=DEFLECTION):
    found = local_slopes(TIME, force, deflection)
    return found, (found.stiffness - STIFFNESS[found.index]) / STIFFNESS[found.index]


def test_the_slope_of_a_spring_is_found_without_its_law():
    found, error = errors(sinh_force(DEFLECTION))
    assert len(found.index) > 200
    assert np.abs(error).max() < 0.002


@pytest.mark.parametrize(
    "rate_effect",
    [
        600.0 * VELOCITY - 1.5e4 * VELOCITY * np.abs(VELOCITY),
        0.5 * np.tanh(VELOCITY / 1e-4),
        -0.005 * STIFFNESS * VELOCITY,
    ],
    ids=("damper", "friction", "delay"),
)
def test_rate_effects_do_not_bias_the_slope(rate_effect):
    found, error = errors(sinh_force(DEFLECTION) + rate_effect)
    assert len(found.index) > 200
    assert np.median(np.abs(error)) < 0.003
    assert abs(np.median(error)) < 0.001
    assert np.abs(error).max() < 0.03


def test_the_interval_of_the_slope_contains_the_truth():
    random = np.random.default_rng(5)
    inside = []
    for _ in range(4):
        noisy = DEFLECTION + 1e-5 * random.standard_normal(TIME.size)
        found, error = errors(sinh_force(DEFLECTION) + 0.05 * random.standard_normal(TIME.size), noisy)
        inside.append(np.mean(np.abs(error) * found.stiffness <= 1.96 * found.std))
    assert 0.85 < np.mean(inside) <= 1.0


def test_strokes_in_one_direction_only_do_not_define_a_slope():
    """In a single stroke deflection and velocity are functions of each other."""
    one_way = 0.005 + 0.010 * TIME / TIME[-1]
    force = sinh_force(one_way) + 0.017 * np.random.default_rng(1).standard_normal(TIME.size)
    assert len(local_slopes(TIME, force, one_way).index) == 0


def written(folder, name, force, count=TIME.size, **more):
    columns = {"stamp": 100.0 + TIME, "force": force, "deflection": DEFLECTION, **more}
    write_columns(folder / name, {key: column[:count] for key, column in columns.items()})
    return folder / name


def test_a_recording_with_its_truth_is_compared_with_both(tmp_path):
    path = written(tmp_path, "a.csv", sinh_force(DEFLECTION), true_stiffness=STIFFNESS)
    entries = {(one["start"], one["reference"]): one for one in compare(path)}
    assert len(entries) == 5
    assert entries["default", "truth"]["points"] == pytest.approx(0.7 * len(TIME), abs=1)
    assert entries["local regression", "truth"]["stiffness"]["error"] < 0.002
    for start in ("default", "identify"):
        against, truth = (entries[start, name]["stiffness"] for name in ("local regression", "truth"))
        assert against["valid"] == pytest.approx(truth["valid"], abs=0.1)


def test_identified_start_values_of_an_exponential_spring_give_its_stiffness(tmp_path):
    stiffness = 0.776 * 267.2 * np.exp(267.2 * DEFLECTION)
    force = 16.39 + stiffness / 267.2 + 600.0 * VELOCITY + 0.017 * np.random.default_rng(2).standard_normal(TIME.size)
    path = written(tmp_path, "a.csv", force, true_stiffness=stiffness)
    (figures,) = (
        one["stiffness"] for one in compare(path) if (one["start"], one["reference"]) == ("identify", "truth")
    )
    assert figures["valid"] > 0.9
    assert figures["error"] < 0.01


def test_short_and_unreadable_files_are_skipped_with_one_line_each(tmp_path):
    written(tmp_path, "good.csv", sinh_force(DEFLECTION))
    written(tmp_path, "short.csv", sinh_force(DEFLECTION), count=MIN_SAMPLES - 1)
    (tmp_path / "broken.csv").write_text("stamp,force\n1,2\n")
    (tmp_path / "note.txt").write_text("none")
    entries, skipped = compare_all(tmp_path)
    assert {one["recording"] for one in entries} == {"good.csv"}
    assert len(skipped) == 2
    assert "expected the columns" in skipped[0]
    assert skipped[1] == "short.csv: fewer than 500 samples"
