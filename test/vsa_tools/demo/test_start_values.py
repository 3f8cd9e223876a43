# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The initial coefficients of the demo have the errors that the README states."""

import numpy as np
import pytest
from vsa_tools.demo.start_values import perturbed

TRUTH = {"k2": 267.2, "d1": 4000.0, "d2": -1.089e8, "inertia": 0.3755, "force_offset": 16.39}
FORCE = 29.2


@pytest.mark.parametrize("seed", range(20))
def test_every_initial_coefficient_is_perturbed(seed):
    start = perturbed(TRUTH, FORCE, np.random.default_rng(seed))
    assert start["k2"] / TRUTH["k2"] in (pytest.approx(0.7), pytest.approx(1.3))
    stiffness = start["k2"] * (FORCE - start["force_offset"])
    assert stiffness / (267.2 * (FORCE - 16.39)) in (pytest.approx(0.5), pytest.approx(2.0))
    for name in ("d1", "d2", "inertia"):
        assert abs(start[name] / TRUTH[name] - 1.0) >= 0.39


def test_the_seed_determines_the_perturbation():
    starts = [perturbed(TRUTH, FORCE, np.random.default_rng(seed)) for seed in (1, 1, 2, 3, 4, 5)]
    assert starts[0] == starts[1]
    assert any(start != starts[0] for start in starts[2:])
