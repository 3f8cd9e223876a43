# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The D-optimal motion: within its limits, best by the criterion, and best by the estimator on the simulated rig."""

from dataclasses import replace

import numpy as np
import pytest
from rig_runs import GOAL, Run, changed, ln_determinant
from test_balance import MODELS, START
from vsa_joint.excitation.design import Design, Task, choose_motion, ln_determinants
from vsa_joint.excitation.multisine import Multisine, Range, fade, family, paths

TASK = Task(MODELS, START, 0.0, Range(-0.0035, 0.0035, 0.005), GOAL.quantities, 500.0)
TIME = np.arange(0.0, 60.0, 0.01)


def test_every_motion_of_the_family_is_within_range_and_speed():
    limits = Range(-0.001, 0.003, 0.002)
    for motion in family(limits, 0.0035):
        mean = motion(TIME)
        assert limits.low - 1e-9 <= mean.min()
        assert mean.max() <= limits.high + 1e-9
        assert np.abs(np.diff(mean)).max() / 0.01 <= limits.speed * 1.001


def test_the_chosen_motion_has_the_least_criterion_of_the_family():
    design = choose_motion(TASK)
    every = ln_determinants(TASK, TASK.motions())
    assert design.ln_determinant == pytest.approx(every.min())
    assert design.ln_determinant < np.median(every) - 2.0
    assert design.motion in TASK.motions()


def test_the_criterion_of_one_motion_does_not_depend_on_the_others():
    motions = TASK.motions()
    alone = ln_determinants(TASK, motions[7:8])
    assert alone[0] == pytest.approx(ln_determinants(TASK, motions)[7], rel=1e-6)


def test_a_stiffness_alone_takes_a_slower_motion_than_the_cubic_damping():
    stiffness, damping = (choose_motion(replace(TASK, quantities=(name,))).motion for name in ("stiffness", "d2"))
    speed = [np.abs(np.diff(one(TIME))).max() for one in (stiffness, damping)]
    assert speed[0] < speed[1]


def test_a_range_without_room_is_an_error():
    with pytest.raises(ValueError, match=r"no motion within 0\.001 mm to either side"):
        choose_motion(replace(TASK, limits=Range(-1e-6, 1e-6, 0.005)))


def test_a_path_begins_at_rest_and_becomes_the_motion():
    motion = Multisine(0.001, (0.002,), (0.1,))
    path = paths([motion], -0.0005, 0.02, 200)[0]
    assert path[0] == pytest.approx(-0.0005, abs=1e-6)
    assert path[-1] == pytest.approx(float(motion(np.array(4.0))), abs=1e-9)
    assert fade(np.array([-1.0, 0.0, 10.0])) == pytest.approx([0.0, 0.0, 1.0])


def test_the_text_of_a_motion_has_amplitudes_and_frequencies():
    assert str(Multisine(0.0, (-0.003, 1e-4), (0.1, 0.7))) == "3 mm at 0.1 Hz + 0.1 mm at 0.7 Hz"
    assert str(Multisine(0.0)) == "at rest"


def test_on_the_rig_the_chosen_motion_gives_smaller_standard_deviations_than_arbitrary_ones():
    """Three random members of the family, the same noise; after 10 s by the covariance of the estimator."""
    goal = changed(GOAL, quantities=(*GOAL.quantities, "inertia"), duration=10.0)

    def arbitrary(rng):
        def choose(task):
            motions = task.motions()
            return Design(motions[rng.integers(len(motions))], 0.0)

        return choose

    for seed in (0, 1, 2):
        chosen = Run(seed, goal)
        chosen.finish()
        other = Run(seed, goal, choose=arbitrary(np.random.default_rng(100 + seed)))
        other.finish()
        assert chosen.procedure.elapsed(chosen.now) == pytest.approx(10.0, abs=0.02)
        assert ln_determinant(chosen) < ln_determinant(other)
