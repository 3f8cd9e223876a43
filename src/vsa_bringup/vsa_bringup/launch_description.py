# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The only module that imports the launch system: a launch description from arguments and programs."""

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from launch import LaunchContext, LaunchDescription  # type: ignore[attr-defined]  # mypy finds the folder of this name
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch_ros.actions import Node
from vsa_bringup.arguments import RESPAWN, SHUTDOWN, arguments, check_names, options
from vsa_bringup.deployment import processes
from vsa_bringup.process import Process, Program
from vsa_common.config.joints import DEFAULT

RESPAWN_DELAY_S = 1.0

Actions = Callable[[LaunchContext], list[Node]]


def launch_description(file: str, programs: Sequence[Program], namespace: str = DEFAULT) -> LaunchDescription:
    """Launch description of the launch file `file`; `ros2 launch vsa_bringup FILE --show-args` lists its arguments.

    `namespace` is the default of the argument of this name. The arguments are checked before a process starts.
    """
    declared = [
        DeclareLaunchArgument(one.name, default_value=one.default, description=_description(one.text, one.choices))
        for one in arguments(namespace)
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=_actions(file, programs))])


def _actions(file: str, programs: Sequence[Program]) -> Actions:
    names = [one.name for one in arguments()]

    def actions(context: LaunchContext) -> list[Node]:
        if _is_launched_directly(file):
            check_names(context.argv, names)
        values = {name: context.launch_configurations[name] for name in names}
        return [_node(process) for process in processes(options(values), programs)]

    return actions


def _is_launched_directly(file: str) -> bool:
    """Whether `ros2 launch` has the file on its command line; a file that includes it has other arguments."""
    return Path(file).name in {Path(word).name for word in sys.argv}


def _node(process: Process) -> Node:
    words: dict[str, Any] = {}
    if process.on_exit == RESPAWN:
        words |= {"respawn": True, "respawn_delay": RESPAWN_DELAY_S}
    elif process.on_exit == SHUTDOWN:
        words["on_exit"] = Shutdown(reason=f"{process.executable} has ended")
    return Node(
        package=process.package,
        executable=process.executable,
        name=process.name or None,
        namespace=f"/{process.namespace}" if process.namespace else None,
        parameters=list(process.parameter_files),
        arguments=list(process.arguments),
        ros_arguments=["--log-level", process.log_level] if process.log_level else [],
        output="screen",
        **words,
    )


def _description(text: str, choices: Sequence[str]) -> str:
    return f"{text}; one of {', '.join(choices)}" if choices else text
