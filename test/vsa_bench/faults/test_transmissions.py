# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Faults of the sensors on a transmission whose law the filter does not have."""

import math

import pytest
from vsa_bench.faults.cases import FaultCase
from vsa_bench.faults.run import run_fault
from vsa_common.accel import ACCELERATED

pytestmark = pytest.mark.skipif(not ACCELERATED, reason="the bank of laws is too slow in plain Python")


@pytest.mark.parametrize(("fault", "limit"), [("force_bias_1n", 0.5), ("force_drift_0.5n", 2.0)])
def test_a_fault_of_the_force_is_detected_and_the_stiffness_valid_after_it(fault, limit):
    figures = run_fault(FaultCase(fault, 2.0, "mix", 100), 5, "spring_quadratic")
    assert figures["valid_before"]
    assert figures["detected_after_s"] < limit
    assert figures["longest_wrong_s"] < 0.1
    assert figures["time_to_valid_s"] < 1.0


@pytest.mark.parametrize("duration", [math.inf, 2.0])
def test_an_encoder_step_shifts_the_law(duration):
    figures = run_fault(FaultCase("encoder_step_1mm", duration, "steps", 100), 5, "spring_quadratic")
    assert figures["named"] == figures["expected"]
    assert figures["longest_wrong_s"] < 0.1
    assert figures["time_to_valid_s"] < 1.5
