# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Joints of a process, from its parameter files."""

import pytest
from vsa_common.config.configuration import ConfigurationError
from vsa_common.config.joints import joints

SHARED = "/**/driver: {ros__parameters: {silence: 0.2}}\n"
LEFT = "/left/driver: {ros__parameters: {counters_rate: 5.0}}\n/left/joint: {ros__parameters: {}}\n"
NESTED = "lab: {left: {driver: {ros__parameters: {silence: 0.2}}}}\n"
RIGHT = "/lab/right/driver: {ros__parameters: {}}\n"


def arguments(folder, *texts):
    words = ["driver", "--ros-args"]
    for i, text in enumerate(texts):
        (folder / f"{i}.yaml").write_text(text)
        words += ["--params-file", str(folder / f"{i}.yaml")]
    return words


@pytest.mark.parametrize(
    ("texts", "found"),
    [
        ((), ["vsa"]),
        ((SHARED,), ["vsa"]),
        ((SHARED + LEFT,), ["left"]),
        ((SHARED + LEFT, RIGHT + LEFT), ["left", "lab/right"]),
        ((SHARED + NESTED + RIGHT,), ["lab/left", "lab/right"]),
    ],
)
def test_a_joint_is_a_namespace_in_which_a_file_names_a_driver(tmp_path, texts, found):
    assert joints(arguments(tmp_path, *texts)) == found


def test_a_remapped_namespace_selects_one_joint(tmp_path):
    assert joints([*arguments(tmp_path, LEFT + RIGHT), "-r", "__ns:=/lab/right"]) == ["vsa"]


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(ConfigurationError, match=r"nothing\.yaml"):
        joints(["driver", "--ros-args", "--params-file", str(tmp_path / "nothing.yaml")])
