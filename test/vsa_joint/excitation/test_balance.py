# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Predicted motions of both transmissions, the range and its limits."""

import dataclasses

import numpy as np
import pytest
from rig_runs import GOAL, model
from vsa_joint.excitation.balance import Start, balanced_motions, static_deflections
from vsa_joint.excitation.limits import excess, motor_range, predicted_range, shortfall
from vsa_joint.excitation.settings import ExcitationConfig

SECOND = model(
    deflection_reference=0.0,
    ln_stiffness=np.log(7.031 * 165.6),
    k2=165.6,
    d2=-1.17e8,
    inertia=0.2295,
    force_offset=8.269,
)
MODELS = (model(), SECOND)
FORCE = float(MODELS[0].force(np.array(0.0105), np.array(0.0)))
START = Start((0.0105, float(np.log((FORCE - 8.269) / 7.031) / 165.6)), (0.0215, 0.0215))
CONFIG = ExcitationConfig()


def test_both_forces_are_equal_at_rest_and_the_mean_is_the_commanded_one():
    mean = np.array([-0.003, 0.0, 0.002])
    first, second = static_deflections(mean, START, MODELS)
    rest = np.zeros(3)
    assert MODELS[0].force(first, rest) == pytest.approx(MODELS[1].force(second, rest), rel=1e-6)
    assert 0.5 * (first + second - sum(START.deflections)) == pytest.approx(mean)


def test_other_radii_balance_the_torques():
    start = dataclasses.replace(START, radii=(0.02, 0.01))
    first, second = static_deflections(np.array([0.002]), start, MODELS)
    rest, external = np.zeros(1), 0.02 * FORCE - 0.01 * FORCE
    torque = 0.02 * MODELS[0].force(first, rest) - 0.01 * MODELS[1].force(second, rest)
    assert torque == pytest.approx(external, rel=1e-6)


def test_equal_transmissions_move_alike():
    mean = 0.001 * np.sin(np.arange(500) * 0.02)[None, :]
    start = Start((0.0105, 0.0105), (0.0215, 0.0215))
    first, second = balanced_motions(mean, 0.0, 0.02, start, (model(), model()))
    assert first.deflection == pytest.approx(0.0105 + mean, abs=1e-9)
    assert second.velocity == pytest.approx(first.velocity, abs=1e-9)


def test_a_slow_motion_is_the_static_one():
    mean = 0.002 * np.sin(np.arange(2000) * 2.0 * np.pi / 2000)
    first, _ = balanced_motions(mean, 0.0, 10.0, START, MODELS)
    assert first.deflection == pytest.approx(static_deflections(mean, START, MODELS)[0], abs=2e-6)


def test_dampers_dominate_a_fast_motion():
    """Equal dampers share a motion of 5 Hz equally, whatever the springs are."""
    time = 0.005 * np.arange(2000)
    mean = 2e-5 * np.sin(2.0 * np.pi * 5.0 * time)
    first, second = balanced_motions(mean, 0.0, 0.005, START, MODELS)
    amplitudes = [np.ptp(one.deflection[1000:]) for one in (first, second)]
    assert amplitudes[0] == pytest.approx(amplitudes[1], rel=0.05)


def test_the_range_keeps_forces_and_deflections_within_their_limits():
    goal = dataclasses.replace(GOAL, force_max=40.0)
    limits = predicted_range(MODELS, START, (FORCE, FORCE), CONFIG, goal)
    assert limits.low == -goal.travel
    assert 0.0 < limits.high < goal.travel
    first, _ = static_deflections(np.array([limits.high]), START, MODELS)
    assert 38.5 < MODELS[0].force(first, np.zeros(1))[0] <= 40.0


def test_limits_are_named():
    assert excess((30.0, 200.0), (0.01, 0.01), CONFIG, GOAL) == "force of transmission_2 200 N, limit 190 N"
    assert excess((30.0, 30.0), (0.021, 0.01), CONFIG, GOAL) == "deflection of transmission_1 21 mm, limit 20 mm"
    assert shortfall((0.01, 1e-4), CONFIG) == "deflection of transmission_2 0.1 mm, limit 0.5 mm"
    assert excess((30.0, 30.0), (0.01, 0.01), CONFIG, GOAL) == shortfall((0.01, 0.01), CONFIG) == ""


def test_the_travel_of_the_motors_limits_the_mean_deflection():
    """A motor's radian is 10 mm of tendon and 5 mm of mean deflection."""
    assert motor_range(CONFIG, (7.9, 1.0)) == pytest.approx((-0.02, 0.0005))
