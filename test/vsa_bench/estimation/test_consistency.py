# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Consistency of the estimator on recordings that are critical for it: no valid estimate far outside its interval."""

import numpy as np
import pytest
from vsa_bench.estimation.cases import case
from vsa_bench.estimation.methods import METHODS
from vsa_bench.estimation.recordings import record
from vsa_bench.estimation.score import confidently_wrong, time_to_accuracy
from vsa_bench.estimation.starts import draw


def run(transmission, motion, seed, **changes):
    one = case(transmission, motion, **changes)
    recording = record(one, [seed])
    start = draw(one, float(recording.truth.deflection[0]), seed)
    return METHODS["force"](recording, [start]), recording


@pytest.mark.parametrize(("transmission", "seed"), [("transmission_1", 81042), ("transmission_2", 81029)])
def test_fast_strokes_do_not_reset_a_consistent_filter(transmission, seed):
    track, recording = run(transmission, "multisine", seed)
    error = np.log(track.stiffness / recording.truth.stiffness)
    assert time_to_accuracy(error, recording.truth.time)[0] < 15.0


@pytest.mark.parametrize(
    ("transmission", "motion", "seed"),
    [
        ("transmission_1", "multisine", 41005),
        ("transmission_1", "slow2", 41005),
        ("transmission_1", "half_hz", 41005),
        ("transmission_1", "half_hz", 1680322833),
        ("transmission_1", "slow", 1624528405),
        ("transmission_2", "slow", 138123108),
    ],
)
def test_with_a_heavy_mass_no_valid_estimate_is_outside_its_interval(transmission, motion, seed):
    track, recording = run(transmission, motion, seed, mass="heavy")
    wrong = confidently_wrong(track, recording)
    assert wrong["inertia"] == 0.0
    assert wrong["stiffness"] == 0.0


@pytest.mark.parametrize(
    ("transmission", "seed"),
    [
        ("transmission_1", 4170990700),
        ("transmission_1", 4248281612),
        ("transmission_1", 4270396371),
        ("transmission_2", 3065463558),
    ],
)
def test_with_a_heavy_mass_of_another_rig_on_a_slow_tone_no_valid_estimate_is_outside_its_interval(transmission, seed):
    track, recording = run(transmission, "slow", seed, mass="heavy", rig="other")
    assert confidently_wrong(track, recording) == {"stiffness": 0.0, "damping": 0.0, "inertia": 0.0}


def test_at_speeds_near_the_peak_speed_valid_damping_is_within_its_interval():
    track, recording = run("transmission_2", "multisine", 130587564, rig="other")
    assert confidently_wrong(track, recording)["damping"] < 0.01
