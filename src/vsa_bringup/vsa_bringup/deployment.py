# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Processes of a launch file from its options; without the launch system, so that tests need none."""

from collections.abc import Iterator, Sequence
from typing import Any

from vsa_bringup.arguments import Options
from vsa_bringup.overrides import overrides, write_parameters
from vsa_bringup.process import Process, Program
from vsa_bringup.robot_description import description_processes

SEPARATE = (
    Program("vsa_driver", "driver", ("driver",)),
    Program("vsa_estimator", "estimator", ("estimator_1",)),
    Program("vsa_estimator", "estimator", ("estimator_2",)),
    Program("vsa_joint", "joint", ("joint",)),
)
COMPOSED = (Program("vsa_bringup", "composed", ("driver", "estimator_1", "estimator_2", "joint")),)
CONTROLLER = Program("vsa_joint", "stiffness_controller", ("stiffness_controller",))
RIG = Program("vsa_simulator", "rig_simulator", ("rig_simulator",))


def processes(options: Options, programs: Sequence[Program]) -> list[Process]:
    """Processes for all joints of the options. Raises ConfigurationError for a package that is not installed.

    A program with several nodes is one process for all joints; without a namespace it finds them in its parameter file.
    """
    started = [*programs, CONTROLLER] if options.controller else list(programs)
    simulated = RIG in programs
    result = []
    for program in started:
        if len(program.nodes) > 1 and not options.one_namespace:
            result.append(_process(options, program, options.namespaces, simulated))
        else:
            result += [_process(options, program, (space,), simulated) for space in options.namespaces]
    for index, space in enumerate(options.namespaces):
        result += [*_tools(options, space, index), *description_processes(options, space)]
    return result


def _process(options: Options, program: Program, namespaces: Sequence[str], simulated: bool) -> Process:
    changes: dict[str, dict[str, Any]] = {}
    for space in namespaces:
        for node in program.nodes:
            changes |= overrides(options, space, node, simulated)
    one = len(program.nodes) == 1
    return Process(
        package=program.package,
        executable=program.executable,
        name=program.nodes[0] if one else "",
        namespace=namespaces[0] if one or options.one_namespace else "",
        parameter_files=(options.config, *([write_parameters(changes)] if changes else [])),
        log_level=options.log_level,
        on_exit=options.on_exit,
    )


def _tools(options: Options, namespace: str, index: int) -> Iterator[Process]:
    """Recorder and live page of one joint."""
    if options.record:
        several = len(options.namespaces) > 1
        folder = f"{options.record}_{namespace.replace('/', '_')}" if several else options.record
        default = options.record.lower() == "true"
        yield Process(
            package="vsa_tools",
            executable="record",
            name="recorder",
            namespace=namespace,
            parameter_files=(options.config,),
            arguments=() if default else ("--out", folder),
            log_level=options.log_level,
        )
    if options.view:
        words = ("--namespace", f"/{namespace}", "--port", str(options.view + index))
        yield Process("vsa_tools", "view", arguments=words)
