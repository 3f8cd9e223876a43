# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Recordings of the ablation, figures of a run, and trials of the estimator."""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import numpy as np
import pytest
from vsa_bench.ablation import trial
from vsa_bench.ablation.command import ablate
from vsa_bench.ablation.figures import Figures, figures
from vsa_bench.ablation.recordings import (
    FAULTS,
    simulated,
    with_change,
    with_encoder_step,
    with_force_drift,
    with_sensor_faults,
)
from vsa_bench.ablation.report import chosen
from vsa_bench.ablation.trial import TrialError, initialize_worker, run_trial
from vsa_bench.ablation.variation import HALF, declared, vary
from vsa_bench.estimation.cases import case

WITHOUT_ERROR = Figures(
    stiffness_nrmse=0.0, damping_nrmse=0.0, stiffness_coverage=1.0, damping_coverage=1.0, convergence_time_s=0.0,
    stiffness_valid=1.0, damping_valid=1.0, wrong=0.0, resets=0,
)  # fmt: skip


@pytest.fixture(scope="module")
def multisine():
    return simulated(case(motion="multisine", start="good"), "force", 6.0)


def test_figures_of_the_truth_are_without_error(multisine):
    ones = np.ones(len(multisine.force))
    estimates = {"stiffness": multisine.stiffness, "damping": multisine.damping}
    estimates |= {f"{name}_{part}": ones for name in ("stiffness", "damping") for part in ("valid", "variance")}
    assert figures(multisine, estimates, 0) == WITHOUT_ERROR
    dropped = {name: np.where(np.arange(ones.size) % 2, values, np.nan) for name, values in estimates.items()}
    assert figures(multisine, dropped, 0) == WITHOUT_ERROR
    wrong = figures(multisine, estimates | {"stiffness": 1.1 * multisine.stiffness, "stiffness_variance": ones}, 3)
    assert wrong.stiffness_nrmse == pytest.approx(0.1)
    assert (wrong.wrong, wrong.stiffness_coverage, wrong.convergence_time_s, wrong.resets) == (1.0, 0.0, None, 3)


def test_sensor_faults_leave_stamps_ordered_and_the_truth_aligned(multisine):
    faulty = with_sensor_faults(multisine)
    assert faulty.name == FAULTS
    assert (np.diff(faulty.stamps_ns) >= 0).all()
    received = np.isin(multisine.stiffness, faulty.stiffness)
    assert received.sum() == len(faulty.stiffness) < len(received)


def test_an_encoder_step_leaves_the_truth_as_it_is(multisine):
    stepped = with_encoder_step(multisine)
    half = len(multisine.force) // 2
    assert (stepped.deflection - multisine.deflection)[half:] == pytest.approx(1e-3)
    np.testing.assert_array_equal(stepped.deflection[:half], multisine.deflection[:half])
    np.testing.assert_array_equal(stepped.stiffness, multisine.stiffness)


def test_a_force_drift_leaves_the_truth_as_it_is(multisine):
    error = with_force_drift(multisine).force - multisine.force
    half = len(error) // 2
    np.testing.assert_array_equal(error[:half], 0.0)
    assert (np.diff(error[half:]) > -1e-12).all()
    assert error[-1] == pytest.approx(2.0)


def test_a_changed_transmission_changes_samples_and_truth_together(multisine):
    other = simulated(case(motion="multisine", start="good", rig="other"), "force", 6.0)
    changed, half = with_change(multisine, other), len(multisine.force) // 2
    for name in ("force", "deflection", "stiffness", "damping", "damping_defined"):
        np.testing.assert_array_equal(getattr(changed, name)[:half], getattr(multisine, name)[:half])
        np.testing.assert_array_equal(getattr(changed, name)[half:], getattr(other, name)[half:])


def in_worker(recordings, *overrides):
    with ProcessPoolExecutor(1, get_context("fork"), initialize_worker, (recordings,)) as pool:
        return list(pool.map(run_trial, overrides))


def test_a_trial_runs_in_plain_python_and_repeats_to_the_bit(multisine):
    first, second = in_worker([multisine], {}, {})
    assert first.failure == ""
    assert first == second
    assert first.figures[multisine.name].stiffness_nrmse < 0.2
    assert trial.OVERRIDES == {}


def test_an_estimator_that_fails_with_the_tuned_values_ends_the_bench(multisine):
    invalid = replace(multisine, parameters=multisine.parameters | {"filter_rate": -1.0})
    with pytest.raises(TrialError, match=r"with the tuned values: .*filter_rate"):
        ablate([invalid], [], 1)


def test_a_constant_of_the_estimator_changes_its_outputs(multisine):
    constants = declared(trial.PACKAGE)
    variations = [vary(module, one, HALF) for module, one in chosen(constants, ["supervisor.REFRESH_PERIOD"])]
    base, effects = ablate([with_sensor_faults(multisine)], variations, 1)
    (one,) = effects
    assert base.failure == one.trial.failure == ""
    assert one.variation.value == 0.5 * constants["vsa_estimator.tuning.supervisor"]["REFRESH_PERIOD"].value
    assert one.bits_changed
