# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Half and double of tuned constants, and their application to a package that is imported anew."""

import importlib

import pytest
from vsa_bench.ablation.trial import import_anew
from vsa_bench.ablation.variation import DOUBLE, HALF, declared, vary
from vsa_common.tuning import CONSTANTS, OVERRIDES, Constant


def constant(value, low=-1e9, high=1e9, name="GATE"):
    return Constant(name, value, "", low, high, "reason", "ablation")


def value(one, factor):
    varied = vary("filter", one, factor)
    return varied and (varied.value, varied.clipped)


@pytest.mark.parametrize(
    ("tuned", "half", "double"),
    [
        (3.0, 1.5, 6.0),
        (-4.0, -2.0, -8.0),
        (5, 3, 10),
        (1, None, 2),
        (0.0, None, None),
        ((1.0, 4.0), (0.5, 2.0), (2.0, 8.0)),
    ],
)
def test_a_constant_is_halved_and_doubled_in_its_own_type(tuned, half, double):
    for factor, expected in ((HALF, half), (DOUBLE, double)):
        varied = vary("filter", constant(tuned), factor)
        assert (varied and varied.value) == expected
        assert varied is None or type(varied.value) is type(tuned)


def test_a_value_out_of_range_is_clipped_and_marked():
    assert value(constant(3.0, 2.0, 5.0), HALF) == (2.0, True)
    assert value(constant(3.0, 2.0, 5.0), DOUBLE) == (5.0, True)
    assert value(constant(5, 1, 8), DOUBLE) == (8, True)
    assert value(constant(3.0, 3.0, 6.0), HALF) is None
    assert value(constant(3.0, 3.0, 6.0), DOUBLE) == (6.0, False)
    assert value(constant(-4.0, -5.0, -1.0), DOUBLE) == (-5.0, True)


def test_a_tuple_keeps_its_ratios_where_its_range_clips_it():
    assert value(constant((1.0, 4.0), 0.0, 6.0), DOUBLE) == ((1.5, 6.0), True)


@pytest.fixture
def tuned_package(tmp_path, monkeypatch):
    """A package with two constants; one of them determines another that is computed at import."""
    package = tmp_path / "tuned_sample"
    (package / "tuning").mkdir(parents=True)
    (package / "__init__.py").write_text("")
    (package / "tuning" / "__init__.py").write_text("")
    (package / "tuning" / "filter.py").write_text(
        "from vsa_common.tuning import constant\n"
        'GATE = constant("GATE", 3.0, "", 1.0, 10.0, "outliers", "ablation", module=__name__)\n'
        'SPARE = constant("SPARE", 7, "", 1, 100, "none", "ablation", module=__name__)\n'
    )
    (package / "model.py").write_text("from tuned_sample.tuning.filter import GATE\nLIMIT = GATE**2\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    yield "tuned_sample"
    import_anew("tuned_sample", {})
    assert not OVERRIDES


def test_constants_of_all_tuning_modules_are_found(tuned_package):
    assert {module: list(members) for module, members in declared(tuned_package).items()} == {
        "tuned_sample.tuning.filter": ["GATE", "SPARE"]
    }
    assert declared("vsa_msgs") == {}


def test_an_override_applies_to_the_constant_and_to_what_is_computed_from_it(tuned_package):
    module = "tuned_sample.tuning.filter"
    for overrides, gate in (({}, 3.0), ({(module, "GATE"): 6.0}, 6.0), ({(module, "SPARE"): 3}, 3.0), ({}, 3.0)):
        import_anew(tuned_package, overrides)
        model = importlib.import_module("tuned_sample.model")
        assert (gate, gate**2) == (model.GATE, model.LIMIT)
        assert CONSTANTS[module]["GATE"].value == gate


def test_an_override_out_of_range_is_refused(tuned_package):
    import_anew(tuned_package, {("tuned_sample.tuning.filter", "GATE"): 11.0})
    with pytest.raises(ValueError, match=r"GATE = 11\.0 : must be within 1 to 10"):
        importlib.import_module("tuned_sample.model")
