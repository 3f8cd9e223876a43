# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Configuration: one declaration of unit and range for parameters, files and error texts."""

from dataclasses import dataclass

import pytest
from vsa_common.config.configuration import (
    ConfigurationError,
    build,
    choice,
    flag,
    flatten,
    group,
    load,
    parameters,
    quantities,
    quantity,
    string,
)


@dataclass(frozen=True)
class Spring:
    k2: float = quantity(267.2, "1/m", 20.0, 5000.0, "growth")


@dataclass(frozen=True)
class Example:
    noise: float = quantity(0.017, "N", 1e-6, 100.0, "noise")
    count: int = quantity(3, "", 0, 10, "how many")
    amplitudes: tuple[float, ...] = quantities((1.0, 2.0), "m", 0.0, 5.0, "of the tones")
    names: tuple[str, ...] = string((), "names")
    kind: str = choice("sine", ("sine", "ramp"), "which")
    quick: bool = flag(False, "or not")
    spring: Spring = group(Spring)


def test_absent_values_keep_their_defaults():
    assert build(Example, {}) == Example()


def test_dotted_names_address_members_of_groups():
    assert build(Example, {"spring.k2": 300.0}).spring.k2 == 300.0


def test_flatten_is_the_inverse_of_build():
    config = build(Example, {"noise": 0.5, "names": ["a", "b"], "spring.k2": 100.0})
    assert build(Example, flatten(config)) == config


def test_an_integer_is_accepted_for_a_float():
    assert build(Example, {"noise": 1}).noise == 1.0


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("noise", -1.0, "noise = -1.0 N: must be within 1e-06 to 100.0 N"),
        ("noise", float("nan"), "noise = nan N: must be within"),
        ("noise", 1e300, "noise = 1e+300 N: must be within"),
        ("noise", "much", "noise = 'much' N: must be a number"),
        ("noise", True, "noise = True N: must be a number"),
        ("count", 2.5, "count = 2.5: must be an integer"),
        ("amplitudes", [1.0, 9.0], "amplitudes = [1.0, 9.0] m: must be within 0.0 to 5.0 m"),
        ("amplitudes", 1.0, "amplitudes = 1.0 m: must be a list, each a number"),
        ("kind", "chirp", "kind = 'chirp': must be one of sine, ramp"),
        ("quick", 1, "quick = 1: must be true or false"),
        ("nois", 1.0, "nois: no such parameter; did you mean noise?"),
    ],
)
def test_a_bad_value_is_rejected_with_name_value_and_unit(name, value, expected):
    with pytest.raises(ConfigurationError) as rejected:
        build(Example, {name: value})
    assert expected in str(rejected.value)


@pytest.mark.parametrize("key", ["estimator_1", "/vsa/estimator_1", "/**/estimator_1", "/**"])
def test_a_parameter_file_is_found_by_every_key_that_ros_accepts(tmp_path, key):
    file = tmp_path / "rig.yaml"
    file.write_text(
        f"{key}:\n  ros__parameters:\n    noise: 0.5\n    spring: {{k2: 300.0}}\n"
        "    autostart: false\n    realtime: {priority: 50}\n"
        "/**/other:\n  ros__parameters: {x: 1}\n"
    )
    config = load(file, "estimator_1", Example)
    assert (config.noise, config.spring.k2) == (0.5, 300.0)


def test_a_parameter_file_with_nested_namespaces_is_read_as_by_ros(tmp_path):
    file = tmp_path / "rig.yaml"
    file.write_text(
        "/**: {ros__parameters: {noise: 0.25}}\n"
        "lab: {left: {estimator_1: {ros__parameters: {noise: 0.5}}}}\n"
        "/lab/right/**: {ros__parameters: {noise: 0.75}}\n"
    )
    assert load(file, "estimator_1", Example).noise == 0.5
    assert load(file, "estimator_2", Example).noise == 0.75


def test_a_node_in_several_namespaces_of_a_parameter_file_is_an_error_that_names_them(tmp_path):
    file = tmp_path / "rig.yaml"
    file.write_text(
        "".join(f"/{side}/estimator_1: {{ros__parameters: {{noise: 0.5}}}}\n" for side in ("left", "right"))
    )
    with pytest.raises(ConfigurationError, match=r"rig\.yaml: estimator_1 is in the namespaces /left and /right"):
        load(file, "estimator_1", Example)


@pytest.mark.parametrize(
    "text", ["a: [1\n b: 2", "just words", "estimator_1: 3", "estimator_1: {ros__parameters: {noise: -1.0}}"]
)
def test_a_bad_file_is_rejected_in_one_line_that_names_it(tmp_path, text):
    file = tmp_path / "rig.yaml"
    file.write_text(text)
    with pytest.raises(ConfigurationError) as rejected:
        load(file, "estimator_1", Example)
    assert "rig.yaml" in str(rejected.value)
    assert "\n" not in str(rejected.value)


def test_every_parameter_has_its_unit_and_meaning():
    described = {parameter.name: (parameter.unit, parameter.text) for parameter in parameters(Example)}
    assert described["spring.k2"] == ("1/m", "growth")
    assert list(described) == ["noise", "count", "amplitudes", "names", "kind", "quick", "spring.k2"]
