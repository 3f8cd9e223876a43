# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Repetitions in slices beside new samples."""

import numpy as np
import pytest
from vsa_common.accel import ACCELERATED
from vsa_estimator.general import repetition
from vsa_estimator.general.bank import Bank
from vsa_estimator.general.models import NESTED, geometry_at, members_at
from vsa_estimator.general.records import INTERVALS, STEP, X
from vsa_estimator.settings import Initial
from vsa_estimator.tuning.general import RELINEARIZATION_TIMES, STEPS_PER_SLICE

pytestmark = pytest.mark.skipif(not ACCELERATED, reason="the bank is too slow in plain Python")


def test_a_slice_is_some_steps_or_one_nested_member(monkeypatch):
    nested, repeated = [], []
    nest, repeat = repetition.nest, repetition.repeat
    monkeypatch.setattr(repetition, "nest", lambda *args: (nested.append(args[-1]), nest(*args)))
    monkeypatch.setattr(repetition, "repeat", lambda *args: (repeated.append(args[-1].size), repeat(*args)))
    bank, random, slices = Bank(Initial(), 100.0), np.random.default_rng(1), []
    for time in np.arange(0.0, 2.0 * RELINEARIZATION_TIMES[0], 0.01):
        deflection = 0.01 + 1e-3 * np.sin(2.0 * time) + 1e-5 * random.standard_normal()
        bank.step(0.01, (deflection, 1e-10), (30.0 + 2000.0 * (deflection - 0.01), 1e-4))
        if bank.is_repeating:
            nested.clear(), repeated.clear()
            bank.repeat_slice()
            slices.append((len(nested), sum(repeated)))
        if bank.repetitions:
            break
    assert bank.repetitions == 1
    assert max(steps for _, steps in slices) == STEPS_PER_SLICE
    assert max(members for members, _ in slices) == 1
    assert all(members == 0 or steps == 0 for members, steps in slices)
    assert sum(members for members, _ in slices) == len(NESTED)
    assert sum(steps for _, steps in slices) == bank._count


@pytest.mark.parametrize(("beyond", "used"), [(-1e-4, True), (1e-4, False)])
def test_a_force_beyond_the_elastic_spline_is_not_used(beyond, used):
    geometry = geometry_at(Initial(), 0.010, Initial().k2)
    end = float(geometry["origin"][0] + INTERVALS * geometry["spacing"][0])
    member, step = members_at(Initial(), geometry, 30.0, 1e-10)[2:3], np.zeros(1, STEP)
    member["mean"][0, X] = step["deflection"] = end + beyond
    step["dt"], step["deflection_variance"], step["force"], step["force_variance"] = 0.01, 1e-10, 60.0, 1e-4
    repetition.advance_member(member, geometry, step)
    assert (member[0]["innovation"] != 0.0) == used
