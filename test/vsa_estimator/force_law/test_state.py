# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
from vsa_estimator.force_law import state
from vsa_estimator.force_law.state import COEFFICIENTS, SIZE, C, Z


def test_the_coefficients_are_the_state_without_the_motion():
    motion = SIZE - COEFFICIENTS
    assert {index.name: index + motion for index in C} == {index.name: index for index in Z if index >= motion}


def test_the_indices_of_compiled_code_are_those_of_the_enumerations():
    assert all(getattr(state, index.name) == index for index in Z)
    assert all(getattr(state, f"C_{index.name}") == index for index in C)
