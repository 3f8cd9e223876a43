# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Sections of parameter files apply to the nodes to which rcl applies them."""

import subprocess
import sys

import pytest
from vsa_common.config.configuration import ConfigurationError
from vsa_common.config.sections import applies, files_without, sections

# Node names and namespaces are words without a hyphen.
PATTERNS = ["/**", "/**/driver", "/*/driver", "/vsa/*", "/vsa/**", "/vsa/driver", "/driver", "driver", "/*", "/vsa"]
NODES = ["/driver", "/vsa/driver", "/vsa/left/driver", "/vsa/joint", "/vsa/driver_2"]

RCL = """
import rclpy, sys
rclpy.init(args=sys.argv)
for name in sys.argv[1].split(","):
    space, _, bare = name.rpartition("/")
    options = {"automatically_declare_parameters_from_overrides": True, "start_parameter_services": False}
    print(rclpy.create_node(bare, namespace=space or "/", **options).has_parameter("mark"))
"""


def test_patterns_apply_as_in_rcl(tmp_path):
    for pattern in PATTERNS:
        (tmp_path / "file.yaml").write_text(f"{pattern}: {{ros__parameters: {{mark: 1}}}}\n")
        command = [sys.executable, "-c", RCL, ",".join(NODES), "--ros-args", "--params-file", tmp_path / "file.yaml"]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
        (name,) = sections(tmp_path / "file.yaml")
        assert [str(applies(name, node)) for node in NODES] == done.stdout.split(), pattern


def test_sections_in_nested_namespaces_are_found(tmp_path):
    (tmp_path / "nested.yaml").write_text(
        "vsa: {left: {driver: {ros__parameters: {a: {b: 1}}}}}\n/**: {ros__parameters:}"
    )
    assert sections(tmp_path / "nested.yaml") == {"/vsa/left/driver": {"a": {"b": 1}}, "/**": {}}


@pytest.mark.parametrize("text", ["vsa: {driver: 3}", "/vsa/driver: {ros__parameters: 3}", "/vsa/driver:"])
def test_a_value_outside_of_a_section_is_named_as_in_rcl(tmp_path, text):
    (tmp_path / "file.yaml").write_text(text)
    with pytest.raises(ConfigurationError, match=r"file\.yaml: /vsa/driver has no ros__parameters"):
        sections(tmp_path / "file.yaml")


def test_files_without_a_section_of_a_node(tmp_path):
    one, two, launch = tmp_path / "one.yaml", tmp_path / "two.yaml", tmp_path / "launch_params_x.yaml"
    one.write_text("/left/driver: {ros__parameters: {a: 1}}")
    two.write_text("/**/joint: {ros__parameters: {a: 1}}")
    launch.write_text("/**: {ros__parameters: {a: 1}}")
    arguments = [
        "driver",
        "--ros-args",
        *(word for file in (one, two, launch) for word in ("--params-file", str(file))),
    ]
    assert files_without(arguments, "/left/driver") == []
    assert files_without(arguments, "/vsa/joint") == []
    assert files_without(arguments, "/right/driver") == [str(one), str(two)]
    assert files_without(["driver"], "/right/driver") == []


def test_a_file_that_is_none_is_named(tmp_path):
    with pytest.raises(ConfigurationError, match=r"absent\.yaml"):
        sections(tmp_path / "absent.yaml")
