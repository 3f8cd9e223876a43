# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The elastic law of EstimatorState: knots of the exponential law, and the serialized message."""

import numpy as np
import pytest
from rclpy.serialization import deserialize_message
from vsa_common.stamps import nanoseconds
from vsa_estimator.estimator import Estimator
from vsa_estimator.output.elastic_law import ElasticLaw, exponential_law
from vsa_estimator.output.messages import StateWriter
from vsa_estimator.settings import EstimatorConfig
from vsa_msgs.msg import EstimatorState

FIELDS = ("elastic_deflection", "elastic_ln_stiffness", "elastic_ln_stiffness_covariance")


def test_two_knots_state_the_exponential_law_and_its_covariance():
    covariance = np.array([[4e-4, 0.02], [0.02, 9.0]])  # of ln stiffness and k2
    law = exponential_law(0.01, (7.0, 250.0, 12.0), covariance)
    assert law.deflection == (0.01, pytest.approx(0.014))
    assert law.ln_stiffness == (7.0, 8.0)
    assert law.force == pytest.approx(12.0 + np.exp(7.0) / 250.0)  # eqs. (2) and (3)
    gradient = np.array([[1.0, 0.0], [1.0, 1.0 / 250.0]])
    assert np.reshape(law.covariance, (2, 2)) == pytest.approx(gradient @ covariance @ gradient.T)


def test_a_diverged_law_has_an_infinite_force_and_is_written():
    law = exponential_law(0.01, (800.0, 250.0, 12.0), np.eye(2))
    assert law.force == np.inf
    state = Estimator(EstimatorConfig()).state()._replace(**law.fields(False))
    message = deserialize_message(StateWriter("transmission_1").write(1, state), EstimatorState)
    assert (message.elastic_force, message.elastic_law_valid) == (np.inf, False)


def test_the_message_has_the_law_of_the_state_at_any_number_of_knots():
    estimator = Estimator(EstimatorConfig())
    for i in range(3):
        estimator.add(10_000_000 * (i + 1), 20.0, 0.01)
    exponential = estimator.state()
    law = ElasticLaw("any spring (93 %)", (0.0, 0.01, 0.02), (6.0, 7.0, 7.5), tuple(map(float, range(9))), 21.0)
    writer = StateWriter("transmission_1")
    for state in (exponential, exponential._replace(**law.fields(True)), exponential):
        message = deserialize_message(writer.write(5_000_000_003, state), EstimatorState)
        assert nanoseconds(message.header.stamp) == 5_000_000_003
        assert message.header.frame_id == "transmission_1"
        assert [tuple(getattr(message, name)) for name in FIELDS] == [getattr(state, name) for name in FIELDS]
        assert (message.elastic_law, message.elastic_law_valid) == (state.elastic_law, state.elastic_law_valid)
        assert (message.elastic_force, message.force_repeated) == (state.elastic_force, state.force_repeated)
        assert tuple(message.observability) == state.observability
        assert tuple(message.coefficient_covariance) == state.coefficient_covariance
