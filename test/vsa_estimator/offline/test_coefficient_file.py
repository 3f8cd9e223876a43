# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Files of coefficients: read back to the bit, one section for each node, no other file is replaced."""

import numpy as np
import pytest
from transmission_data import SLOW, TRANSMISSION_1, record, run, wrong_start
from vsa_common.config.configuration import ConfigurationError, load
from vsa_estimator.estimator import Estimator
from vsa_estimator.initialization.previous_run import NAMES, coefficients_of
from vsa_estimator.offline.coefficient_file import UNITS, coefficients_of_state, read_posterior, update_file
from vsa_estimator.settings import NodeConfig


@pytest.fixture(scope="module")
def state():
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    run(estimator, record(TRANSMISSION_1, SLOW, 16.0))
    return estimator.state()


def test_the_names_are_those_of_the_filter():
    assert tuple(UNITS) == NAMES


def test_a_file_is_read_back_to_the_bit_by_the_service_and_as_a_parameter_file(state, tmp_path):
    path = tmp_path / "new" / "coefficients.yaml"
    update_file(path, "/vsa/estimator_1", coefficients_of_state(state), "transmission_1")
    posterior = read_posterior(path, "estimator_1")
    assert load(path, "estimator_1", NodeConfig).initial.posterior == posterior
    mean, covariance, reference = coefficients_of(load(path, "estimator_1", NodeConfig).initial)
    assert mean.tolist() == [getattr(state, name) for name in NAMES]
    assert covariance.ravel().tolist() == list(state.coefficient_covariance)
    assert reference == state.deflection_reference


def test_a_reader_finds_each_coefficient_with_its_unit(state, tmp_path):
    path = tmp_path / "coefficients.yaml"
    update_file(path, "/vsa/estimator_1", coefficients_of_state(state), "transmission_1, today")
    std = np.sqrt(state.coefficient_covariance[8])
    assert f"# /vsa/estimator_1: k2 = {state.k2:.6g} +- {std:.2g} 1/m\n" in path.read_text()
    assert "# /vsa/estimator_1: transmission_1, today\n" in path.read_text()


def test_a_second_node_adds_its_section_and_the_first_one_replaces_its_own(state, tmp_path):
    path, coefficients = tmp_path / "coefficients.yaml", coefficients_of_state(state)
    for node, remark in (("/vsa/estimator_1", "old"), ("/vsa/estimator_2", "other"), ("/vsa/estimator_1", "new")):
        update_file(path, node, coefficients, remark)
    assert read_posterior(path, "estimator_1") == read_posterior(path, "estimator_2")
    text = path.read_text()
    assert text.count("/vsa/estimator_1: k2") == text.count("/vsa/estimator_2: k2") == 1
    assert "old" not in text
    assert not list(tmp_path.glob("*.part"))


def test_another_law_than_the_exponential_one_has_no_coefficients(state):
    other = state._replace(elastic_law="spline", elastic_deflection=(0.0, 1e-3, 2e-3))
    with pytest.raises(ConfigurationError, match="the law is not exponential \\(spline\\)"):
        coefficients_of_state(other)


def test_another_file_is_not_replaced_and_one_without_coefficients_is_not_loaded(state, tmp_path):
    path = tmp_path / "my_rig.yaml"
    path.write_text("/**/estimator_1: {ros__parameters: {force_noise_std: 0.02}}\n")
    with pytest.raises(ConfigurationError, match="it is not replaced"):
        update_file(path, "/vsa/estimator_1", coefficients_of_state(state), "")
    with pytest.raises(ConfigurationError, match=r"no initial\.posterior for estimator_1"):
        read_posterior(path, "estimator_1")
