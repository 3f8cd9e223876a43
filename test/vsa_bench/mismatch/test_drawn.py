# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Cases drawn at random: reproducible, within the ranges, and different."""

import json

import numpy as np
import pytest
from vsa_bench.mismatch import command
from vsa_bench.mismatch.drawn import (
    DAMPER,
    ERRORS,
    FRICTION,
    HYSTERESIS,
    MAX_ERRORS,
    SPRING,
    STROKE,
    VISCOELASTIC,
    draw,
)
from vsa_simulator.laws.springs import EXPONENTIAL, SPRINGS
from vsa_simulator.rig.config import SensorErrorConfig
from vsa_simulator.rig.recording import Simulation

CASES = [draw(4, number, (100, 1000), "automatic") for number in range(40)]


def identity(case):
    return case.name, case.motion, case.rate_hz, case.variant


def test_a_case_depends_on_base_and_number_alone():
    for number, case in enumerate(CASES):
        assert identity(draw(4, number, (100, 1000), "automatic")) == identity(case)
        assert identity(draw(5, number, (100, 1000), "automatic")) != identity(case)


def test_cases_have_all_springs_both_rates_and_up_to_two_errors_in_their_ranges():
    assert {one.variant.laws.spring.kind for one in CASES} == {EXPONENTIAL, *SPRINGS}
    assert {one.rate_hz for one in CASES} == {100, 1000}
    assert len({one.variant.stamp_jitter for one in CASES}) == 2
    counts = set()
    for one in CASES:
        values = {name: getattr(one.variant.sensor_errors, name) for name in ERRORS}
        changed = {name for name, value in values.items() if value != getattr(SensorErrorConfig(), name)}
        assert all(ERRORS[name][0] <= values[name] <= ERRORS[name][1] for name in changed)
        assert all(name in one.motion for name in changed)
        counts.add(len(changed))
    assert counts == set(range(MAX_ERRORS + 1))


def test_each_case_has_parameters_of_its_laws_in_their_ranges():
    for part, ranges in (("spring", SPRING), ("damper", DAMPER), ("friction", FRICTION)):
        for name, (low, high) in ranges.items():
            values = [getattr(getattr(one.variant.laws, part), name) for one in CASES]
            assert low <= min(values) < max(values) <= high
            assert len(set(values)) == len(CASES)


@pytest.mark.parametrize(("part", "size", "ranges"), [
    ("viscoelastic", "share", VISCOELASTIC), ("hysteresis", "amplitude", HYSTERESIS),
])  # fmt: skip
def test_few_cases_have_a_law_with_memory_and_name_it(part, size, ranges):
    cases = [draw(4, number, (100,), "automatic") for number in range(200)]
    present = [one for one in cases if getattr(getattr(one.variant.laws, part), size)]
    assert 5 <= len(present) <= 40  # 20 +- 4.2 of 200
    assert present == [one for one in cases if part in one.motion.partition(";")[0].split()]
    for name, (low, high) in ranges.items():
        assert all(low <= getattr(getattr(one.variant.laws, part), name) <= high for one in present)


@pytest.mark.parametrize("number", range(8))
def test_the_motion_stays_within_the_stroke(number):
    case = CASES[number]
    deflection = Simulation(case.variant, case.profile, 20.0, 100).deflection
    assert STROKE[0] - 1e-9 <= deflection.min() < deflection.max() <= STROKE[1] + 1e-9
    assert np.ptp(deflection) > 1e-5


def test_the_command_runs_drawn_cases_and_names_them_by_number(tmp_path, capsys):
    file = tmp_path / "drawn.json"
    arguments = ["--drawn", "2", "--seed", "4", "--seconds", "10", "--workers", "1", "--json", str(file)]
    assert command.main(arguments) == 0
    cases = json.loads(file.read_text())["cases"]
    assert [one["case"] for one in cases] == ["drawn 0", "drawn 1"]
    assert [one["motion"] for one in cases] == [one.motion for one in CASES[:2]]
    assert all(len(one["runs"]) == 1 for one in cases)
    text = capsys.readouterr().out
    assert "drawn 1" in text
    assert "required figures" in text
    assert "worst of the motions" not in text


@pytest.mark.parametrize("other", [["--quick"], ["--case", "crosstalk"], ["--motion", "sine"]])
def test_drawn_cases_go_without_the_choice_of_listed_ones(other, capsys):
    with pytest.raises(SystemExit):
        command.main(["--drawn", "3", *other])
    assert "--drawn" in capsys.readouterr().err
