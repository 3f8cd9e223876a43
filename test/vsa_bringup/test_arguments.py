# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Arguments of the launch files: checked values, refusals on one line."""

import pytest
from vsa_bringup.arguments import arguments, check_names, options
from vsa_common.config.configuration import ConfigurationError

DEFAULTS = {one.name: one.default for one in arguments()}


def given(**values):
    return options(DEFAULTS | values)


def test_the_defaults_leave_all_values_to_the_parameter_file():
    found = given()
    assert found.config.endswith("share/vsa_bringup/config/paper_rig.yaml")
    assert found.namespaces == ("vsa",)
    assert (found.autostart, found.use_sim_time, found.log_level, found.bus_interface) == (None, None, "", "")
    assert (found.controller, found.record, found.view, found.rviz) == (False, "", 0, False)


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("autostart", "False", False),
        ("use_sim_time", "true", True),
        ("log_level", "DEBUG", "debug"),
        ("view", "true", 8080),
        ("view", "8090", 8090),
        ("record", "False", ""),
        ("record", "/tmp/bag", "/tmp/bag"),
        ("on_exit", "respawn", "respawn"),
        ("robot_description", "false", False),
    ],
)
def test_a_value_is_read(name, value, expected):
    assert getattr(given(**{name: value}), name) == expected


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("autostart", "yes", "autostart = 'yes': must be one of true, false"),
        ("log_level", "loudest", "log_level = 'loudest': must be one of debug, info, warn, error, fatal"),
        ("on_exit", "stop", "on_exit = 'stop': must be one of continue, respawn, shutdown"),
        ("view", "70000", "view = '70000': must be true, false or a TCP port"),
        ("namespace", "/", "namespace = '/': must be a name"),
        ("namespace", "", "namespace = '': must be a name"),
        ("config", "typo.yaml", "typo.yaml: No such file or directory"),
        ("config", __file__, f"{__file__}: "),
    ],
)
def test_a_value_that_is_none_is_refused(name, value, expected):
    with pytest.raises(ConfigurationError) as error:
        given(**{name: value})
    assert str(error.value).startswith(expected)


def test_an_unknown_name_is_refused_with_the_nearest_one():
    check_names(["namespace:=left", "record:=true"], DEFAULTS)
    with pytest.raises(ConfigurationError, match=r"^namspace: no such argument; did you mean namespace"):
        check_names(["namspace:=left"], DEFAULTS)
    with pytest.raises(ConfigurationError, match=r"^xyz: no such argument; there are config, namespace, "):
        check_names(["xyz:=1"], DEFAULTS)


def test_without_a_namespace_the_joints_are_those_of_the_file(tmp_path):
    file = tmp_path / "two.yaml"
    file.write_text(
        "/left/driver: {ros__parameters: {silence: 0.1}}\n/right/driver: {ros__parameters: {silence: 0.1}}\n"
    )
    assert given(config=str(file), namespace="auto").namespaces == ("left", "right")
    assert given(config=str(file), namespace="/left/").namespaces == ("left",)
