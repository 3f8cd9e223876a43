# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Command line of a node: ROS arguments only."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.utilities import remove_ros_args
from vsa_common.config.configuration import parameter_files, read_parameter_file

_EPILOG = """ROS arguments, after --ros-args:
  --params-file FILE              parameters; docs/reference/interfaces.md lists them
  -p NAME:=VALUE                  one parameter
  -r __ns:=/NAME, -r __node:=NAME namespace and name of the node
  --log-level LEVEL               debug, info, warn, error or fatal
"""


def check_arguments(arguments: Sequence[str], description: str) -> None:
    """End the process with the usage: for `--help` with 0, for arguments that are not ROS arguments with 2.

    Raises ConfigurationError for a parameter file that rcl cannot read.
    """
    parser = argparse.ArgumentParser(
        prog=Path(arguments[0]).name,
        usage="%(prog)s [--help] [--ros-args ...]",
        description=description,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    if unknown := parser.parse_known_args(_outside_ros_arguments(arguments[1:]))[1]:
        parser.error(f"no such argument: {' '.join(unknown)}; ROS arguments stand after --ros-args")
    try:
        remove_ros_args(list(arguments))
    except rclpy_implementation.UnknownROSArgsError as error:
        parser.error(f"no such ROS argument: {error}")
    except rclpy_implementation.RCLInvalidROSArgsError as error:
        check_parameter_files(arguments)
        parser.error(str(error).partition(". Error:")[0])


def check_parameter_files(arguments: Sequence[str]) -> None:
    """Raise ConfigurationError for a `--params-file` that cannot be read; rcl would name a line of its parser."""
    for path in parameter_files(arguments):
        read_parameter_file(path)


def _outside_ros_arguments(words: Sequence[str]) -> list[str]:
    """Words that are not between `--ros-args` and `--`, or the end."""
    outside, is_ros = [], False
    for word in words:
        if word == "--ros-args" or (is_ros and word == "--"):
            is_ros = word == "--ros-args"
        elif not is_ros:
            outside.append(word)
    return outside
