"""Command line of a node: ROS arguments only."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.utilities import remove_ros_args

_EPILOG = """ROS arguments, after --ros-args:
  --params-file FILE              parameters; docs/reference/interfaces.md lists them
  -p NAME:=VALUE                  one parameter
  -r __ns:=/NAME, -r __node:=NAME namespace and name of the node
  --log-level LEVEL               debug, info, warn, error or fatal
"""


def check_arguments(arguments: Sequence[str], description: str) -> None:
    """End the process with the usage: for `--help` with 0, for arguments that are not ROS arguments with 2."""
    parser = argparse.ArgumentParser(
        prog=Path(arguments[0]).name,
        usage="%(prog)s [--help] [--ros-args ...]",
        description=description,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    try:
        others = remove_ros_args(list(arguments))[1:]
    except rclpy_implementation.UnknownROSArgsError as error:
        parser.error(f"no such ROS argument: {error}")
    except rclpy_implementation.RCLInvalidROSArgsError as error:
        parser.error(str(error).partition(". Error:")[0])
    if unknown := parser.parse_known_args(others)[1]:
        parser.error(f"no such argument: {' '.join(unknown)}; ROS arguments stand after --ros-args")
