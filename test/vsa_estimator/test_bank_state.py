# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Choice of the law in state message and interval."""

import numpy as np
import pytest
from transmission_data import MULTISINE, TRANSMISSION_1, measure, record, wrong_start
from vsa_estimator.estimator import Estimator
from vsa_estimator.force_law.state import S, Z
from vsa_estimator.tuning.filter import NIS_THRESHOLD


def test_the_state_of_the_filter_contains_what_the_choice_of_the_law_leaves_open():
    recording = record(TRANSMISSION_1, MULTISINE, 15.0)
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    estimator.add_many(recording.stamp_ns, recording.force, recording.deflection)
    laws, narrow = estimator._supervisor.laws, estimator.state()
    assert not laws.publishes_bank
    before = laws.discrepancies[0]
    assert before < 1e-3
    laws.discrepancies = (before + 1.0, 0.0)
    wide = estimator.state()
    assert wide.ln_stiffness_reference_variance == pytest.approx(narrow.ln_stiffness_reference_variance + 1.0)
    assert narrow.ln_stiffness_reference_valid
    assert not wide.ln_stiffness_reference_valid
    added = np.subtract(wide.elastic_ln_stiffness_covariance, narrow.elastic_ln_stiffness_covariance)
    assert np.allclose(added, 1.0)
    of_coefficients = np.subtract(wide.coefficient_covariance, narrow.coefficient_covariance)
    assert of_coefficients[0] == pytest.approx(1.0)
    assert np.count_nonzero(of_coefficients) == 1


def test_where_the_evidence_is_against_an_exponential_spring_the_bank_is_published_and_the_coefficients_stay():
    recording = record(TRANSMISSION_1, MULTISINE, 25.0)
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    estimator.add_many(recording.stamp_ns, recording.force, recording.deflection)
    supervisor = estimator._supervisor
    laws, before = supervisor.laws, estimator.state()
    laws._laws._another_spring = True
    laws.choose(supervisor.tracker, supervisor.modes, supervisor.step_ns)
    assert laws.publishes_bank
    assert not laws.replaces_filter
    estimator._publish_snapshot()
    published, impedance = estimator.predict_to(supervisor.step_ns + 1), laws.impedance[0]
    at_filter = impedance["slope"] * (supervisor.tracker.position - impedance["motion"][0])
    assert published.stiffness == pytest.approx(np.exp(impedance["ln_stiffness"] + at_filter), rel=1e-5)
    expected = impedance["ln_stiffness_variance"] * published.stiffness**2
    assert published.stiffness_variance == pytest.approx(expected, rel=1e-2)
    assert published.damping == pytest.approx(impedance["damping"], rel=1e-3)
    assert published.inertia == pytest.approx(supervisor.tracker.z[Z.M])
    assert (published.k2, published.d2) == (before.k2, before.d2)
    assert estimator.state().k2_valid


def test_a_bank_that_does_not_explain_the_force_leaves_the_interval_as_it_was():
    recording = record(TRANSMISSION_1, MULTISINE, 25.0)
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    estimator.add_many(recording.stamp_ns, recording.force, recording.deflection)
    supervisor = estimator._supervisor
    laws = supervisor.laws
    before = laws.discrepancies
    assert not laws.publishes_bank
    assert min(before) > 0.0
    laws._laws._mean_nis = 10.0 * NIS_THRESHOLD
    assert not laws._laws.is_adequate
    laws.choose(supervisor.tracker, supervisor.modes, supervisor.step_ns)
    assert not laws.publishes_bank
    assert laws.discrepancies == pytest.approx(before, rel=1e-9)


def test_a_difference_of_filter_and_bank_at_rest_is_no_further_evidence():
    t = np.arange(4500) / 100.0
    stop = np.clip((26.0 - t) / 2.0, 0.0, 1.0)
    x = MULTISINE[0] + stop**3 * sum(a * np.sin(2.0 * np.pi * f * t) for a, f in MULTISINE[1])
    v = np.gradient(x, t)
    recording = measure(TRANSMISSION_1, t, x, v, np.gradient(v, t))
    moving, resting = slice(0, 2800), slice(2800, None)
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    estimator.add_many(recording.stamp_ns[moving], recording.force[moving], recording.deflection[moving])
    supervisor = estimator._supervisor
    before = estimator.state()
    std = np.sqrt(before.ln_stiffness_reference_variance + supervisor.laws.impedance["ln_stiffness_variance"][0])
    supervisor.tracker.z[S] += 3.0 * float(std)  # of both, so that a mean over time would refute the exponential law
    rows = estimator.add_many(recording.stamp_ns[resting], recording.force[resting], recording.deflection[resting])
    assert not supervisor.laws.publishes_bank
    assert rows["stiffness_valid"].all()
    std = np.sqrt(rows["stiffness_variance"]) / rows["stiffness"]
    assert std[-1] < 1.1 * std[100]
