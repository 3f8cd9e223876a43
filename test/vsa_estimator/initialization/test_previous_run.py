# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Start from the coefficients of a previous run: checked first, then valid, or given up where they do not hold."""

import dataclasses
import functools

import numpy as np
import pytest
from transmission_data import ANOTHER, MULTISINE, SLOW, TRANSMISSION_1, Recording, column, record, run, wrong_start
from vsa_common.config.configuration import ConfigurationError
from vsa_common.types import ResetReason, Status
from vsa_estimator.estimator import Estimator
from vsa_estimator.initialization.previous_run import NAMES, coefficients_of
from vsa_estimator.settings import EstimatorConfig, Initial, Posterior

RATE = 100  # [Hz]


def part(recording, begin, end, force=0.0, deflection=0.0):
    """Samples from `begin` to `end` [s] of sensors whose zeros have shifted."""
    cut = slice(int(begin * RATE), int(end * RATE))
    one = Recording(**{field.name: getattr(recording, field.name)[cut] for field in dataclasses.fields(Recording)})
    return dataclasses.replace(one, force=one.force + force, deflection=one.deflection + deflection)


@functools.cache
def previous(motion):
    """Configuration with the coefficients of a run of 40 s, and the samples of the next 30 s."""
    recording = record(TRANSMISSION_1, motion, 70.0)
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    run(estimator, part(recording, 0, 40))
    state = estimator.state()
    values = tuple(getattr(state, name) for name in NAMES)
    posterior = Posterior(NAMES, values, state.coefficient_covariance, state.deflection_reference)
    return with_posterior(wrong_start(TRANSMISSION_1), posterior), recording


def with_posterior(config, posterior):
    return dataclasses.replace(config, initial=dataclasses.replace(config.initial, posterior=posterior))


def first_valid(estimates):
    """Time from the first sample to the first valid stiffness [s]."""
    return float(np.flatnonzero(column(estimates, "stiffness_valid"))[0]) / RATE


@pytest.mark.parametrize("motion", [SLOW, MULTISINE])
def test_a_restart_is_valid_within_a_second_and_as_accurate_as_before(motion):
    config, recording = previous(motion)
    rest = part(recording, 40, 70)
    warm, cold = run(Estimator(config), rest), run(Estimator(wrong_start(TRANSMISSION_1)), rest)
    assert first_valid(warm) < 1.0 < first_valid(cold)
    valid = column(warm, "stiffness_valid") > 0
    error = np.abs(np.log(column(warm, "stiffness") / rest.stiffness))[valid]
    assert error.max() < 0.005
    std = (np.sqrt(column(warm, "stiffness_variance")) / column(warm, "stiffness"))[valid]
    assert (error / std).max() < 4.0
    assert warm[-1].reset_count == 0


def test_before_the_check_nothing_is_valid():
    config, recording = previous(SLOW)
    estimates = run(Estimator(config), part(recording, 40, 40.3))
    assert not any(one.stiffness_valid for one in estimates)
    assert {one.status for one in estimates} == {Status.DEGRADED}


@pytest.mark.parametrize(("force", "deflection"), [(3.0, 0.0), (0.0, 1e-3)])
def test_with_a_zero_that_shifted_between_the_runs_the_coefficients_are_estimated_again(force, deflection):
    config, recording = previous(SLOW)
    rest = part(recording, 40, 70, force, deflection)
    estimates = run(Estimator(config), rest)
    valid = column(estimates, "stiffness_valid") > 0
    error = np.abs(np.log(column(estimates, "stiffness") / rest.stiffness))
    std = np.sqrt(column(estimates, "stiffness_variance")) / column(estimates, "stiffness")
    assert error[valid].max() < 0.1  # the greatest standard deviation of a valid stiffness
    assert (error / std)[valid].max() < 4.0
    assert valid[-1]
    assert (estimates[-1].reset_count, estimates[-1].reset_reason) == (1, ResetReason.INNOVATION)


def test_coefficients_of_another_transmission_are_given_up_and_never_valid_and_wrong():
    config, _ = previous(SLOW)
    recording = record(ANOTHER, SLOW, 60.0)
    estimates = run(Estimator(config), recording)
    valid = column(estimates, "stiffness_valid") > 0
    error = np.abs(np.log(column(estimates, "stiffness") / recording.stiffness))
    assert valid[-1]
    assert error[valid].max() < 0.1
    assert estimates[-1].reset_reason is ResetReason.INNOVATION


def test_a_requested_reset_starts_from_them_again():
    config, recording = previous(SLOW)
    estimator = Estimator(config)
    run(estimator, part(recording, 40, 50))
    estimator.reset()
    assert first_valid(run(estimator, part(recording, 50, 60))) < 1.0


def test_further_names_are_left_out_and_missing_ones_have_their_start_value():
    names = ("k2", "of_a_later_version", "ln_stiffness_reference")
    covariance = np.array([[4.0, 0.1, 0.2], [0.1, 9.0, 0.3], [0.2, 0.3, 0.04]])
    posterior = Posterior(names, (250.0, 7.0, 8.0), tuple(covariance.ravel()), 0.01)
    mean, found, reference = coefficients_of(Initial(posterior=posterior))
    assert mean.tolist() == [8.0, 250.0, 4000.0, -1.089e8, 0.3755, 16.39, 0.3]
    assert found[:2, :2].tolist() == [[0.04, 0.2], [0.2, 4.0]]
    assert found[2:, 2:].tolist() == np.diag([2400.0**2, 1e8**2, 0.4**2, 25.0, 0.3**2]).tolist()
    assert not found[:2, 2:].any()
    assert reference == 0.01


@pytest.mark.parametrize(
    ("posterior", "text"),
    [
        (Posterior(("k2",), (250.0,), (4.0,)), "no ln_stiffness_reference"),
        (
            Posterior(NAMES[:2], (2600.0, 250.0), (0.01, 0.0, 0.0, 4.0)),
            "ln_stiffness_reference 2600, not within -20 to 25",
        ),
        (Posterior(NAMES[:2], (8.0, 2.5), (0.01, 0.0, 0.0, 4.0)), "k2 2.5 1/m, less than 20"),
        (Posterior(NAMES[:2], (8.0, 250.0), (0.01, 1.0, 1.0, 4.0)), "not symmetric and positive semidefinite"),
        (Posterior(NAMES[:2], (8.0, 250.0), (0.01, 0.1, 0.0, 4.0)), "not symmetric and positive semidefinite"),
    ],
)
def test_coefficients_that_are_none_are_rejected(posterior, text):
    with pytest.raises(ConfigurationError, match=text):
        Estimator(with_posterior(EstimatorConfig(), posterior))
    estimator = Estimator(EstimatorConfig())
    with pytest.raises(ConfigurationError, match=text):
        estimator.reconfigure(with_posterior(EstimatorConfig(), posterior))


def test_a_wrong_number_of_values_is_rejected():
    with pytest.raises(ConfigurationError, match="covariance: 1 numbers, expected 4"):
        Posterior(NAMES[:2], (8.0, 250.0), (0.01,))
