# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Options of the recorder as parameters of its node, and its end before it is active."""

import sys

import pytest
import rclpy
from vsa_tools.record import command
from vsa_tools.record.command import ros_arguments


def parameters(words):
    """Parameters of a node with the recorder's options, as rcl reads them."""
    context = rclpy.Context()
    rclpy.init(args=["record", *ros_arguments(words)], context=context)
    try:
        node = rclpy.create_node("recorder", context=context, automatically_declare_parameters_from_overrides=True)
        values = {name: node.get_parameter(name).value for name in ("out", "topics") if node.has_parameter(name)}
        node.destroy_node()
        return values
    finally:
        rclpy.shutdown(context=context)


@pytest.mark.parametrize("out", ["20260514", "true", "1e3", "null", "a b", "it's", "[x]", "/tmp/run-1", "vsa_bag"])
def test_any_name_of_a_folder_is_a_text(out):
    assert parameters(["--out", out]) == {"out": out}


def test_further_topics_are_texts():
    assert parameters(["--topic", "/arm/joint_states", "--topic", "/2"]) == {"topics": ["/arm/joint_states", "/2"]}


def test_an_end_before_the_recording_began_is_reported_in_one_line(monkeypatch, capsys):
    def run(create, arguments):
        rclpy.init(args=arguments)
        try:
            create().destroy_node()
        finally:
            rclpy.shutdown()
        return 0

    monkeypatch.setattr(command, "run", run)
    monkeypatch.setattr(sys, "argv", ["record"])
    assert command.main() == 0
    assert capsys.readouterr().err.splitlines()[-1] == "recorder: ended before the recording began"
