# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The registry of tuned constants."""

import pytest
from vsa_common import tuning


@pytest.fixture(autouse=True)
def constants(monkeypatch):
    """An empty registry for each test."""
    monkeypatch.setattr(tuning, "CONSTANTS", {})


def declare(value, low=0.0, high=10.0, name="GATE", module="filter.tuning"):
    return tuning.constant(name, value, "1", low, high, "Rejects outliers.", "ablation", module=module)


@pytest.mark.parametrize("value", [3, 3.5, (1.0, 10.0)])
def test_a_declared_constant_returns_its_value_and_is_registered_by_module_and_name(value):
    assert declare(value) == value
    assert type(declare(value, module="other")) is type(value)
    declared = tuning.CONSTANTS["filter.tuning"]["GATE"]
    assert declared == ("GATE", value, "1", 0.0, 10.0, "Rejects outliers.", "ablation")
    assert declared.evidence == "ablation"


@pytest.mark.parametrize("value", [0.0, 10.0])
def test_the_limits_of_the_range_are_permitted(value):
    assert declare(value) == value


@pytest.mark.parametrize("value", [-0.1, 11, (1.0, 10.5), float("nan")])
def test_a_value_out_of_its_range_is_rejected_and_not_registered(value):
    with pytest.raises(ValueError, match=r"filter\.tuning\.GATE = .* 1: must be within 0 to 10"):
        declare(value)
    assert not tuning.CONSTANTS


def test_a_second_declaration_of_a_name_is_rejected_within_one_module_only():
    declare(3.0)
    with pytest.raises(ValueError, match=r"filter\.tuning\.GATE is declared twice"):
        declare(4.0)
    assert declare(4.0, module="initialization.tuning") == 4.0
    assert tuning.CONSTANTS["filter.tuning"]["GATE"].value == 3.0
