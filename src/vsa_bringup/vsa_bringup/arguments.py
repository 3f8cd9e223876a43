# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Arguments of the launch files, checked without the launch system."""

import difflib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from ament_index_python.packages import get_package_share_directory
from vsa_common.config.configuration import ConfigurationError
from vsa_common.config.joints import DEFAULT, joints
from vsa_common.config.sections import sections

AUTO, NONE = "auto", "none"
CONTINUE, RESPAWN, SHUTDOWN = "continue", "respawn", "shutdown"
LEVELS = ("debug", "info", "warn", "error", "fatal")
VIEW_PORT = 8080  # TCP port of the live page of the first joint

_BOOLEANS = {"true": True, "false": False}


class Argument(NamedTuple):
    """An argument of a launch file; an empty default leaves the value to the parameter file."""

    name: str
    default: str
    text: str
    choices: tuple[str, ...] = ()


def arguments(namespace: str = DEFAULT) -> list[Argument]:
    """The arguments of a launch file; `namespace` is the default of the argument of this name."""
    config = Path(get_package_share_directory("vsa_bringup"), "config", "paper_rig.yaml")
    switch = tuple(_BOOLEANS)
    return [
        Argument("config", str(config), "parameter file of the rig"),
        Argument("namespace", namespace, "namespace of the joint; auto: each that the parameter file names"),
        Argument("autostart", "", "configure and activate the nodes; default: as in the parameter file", switch),
        Argument("use_sim_time", "", "time of /clock; default: as in the parameter file", switch),
        Argument("log_level", "", "lowest level that is logged; default: info", LEVELS),
        Argument("controller", "false", "start the stiffness controller", switch),
        Argument("record", "false", "record the topics: true, or the folder of the recording"),
        Argument("view", "false", f"live page: true (port {VIEW_PORT}), or a TCP port"),
        Argument("bus_interface", "", "python-can interface, socketcan on a robot; default: as in the parameter file"),
        Argument("bus_channel", "", "channel of the bus, can0; default: as in the parameter file"),
        Argument("on_exit", CONTINUE, "after the end of a node of the suite", (CONTINUE, RESPAWN, SHUTDOWN)),
        Argument(
            "frame_prefix",
            AUTO,
            "begin of each frame_id, or none; auto: as in the parameter file, or NAMESPACE/ unless vsa",
        ),
        Argument("robot_description", AUTO, "robot_state_publisher; auto: where it is installed", (AUTO, *switch)),
        Argument("rviz", "false", "start RViz", switch),
    ]


@dataclass(frozen=True)
class Options:
    """Checked values of the arguments; None and empty texts leave the value to the parameter file."""

    config: str
    namespaces: tuple[str, ...]  # of the joints, without a leading /
    one_namespace: bool  # the argument names it
    autostart: bool | None
    use_sim_time: bool | None
    log_level: str
    controller: bool
    record: str  # folder of the recording; true: named after date and time; empty: none
    view: int  # TCP port; 0: none
    bus_interface: str
    bus_channel: str
    on_exit: str
    frame_prefix: str
    robot_description: bool | None  # None: where it is installed
    rviz: bool


def options(values: Mapping[str, str]) -> Options:
    """Checked values of all `arguments`. Raises ConfigurationError naming the argument, or the parameter file."""
    given = {one.name: _choice(one, values[one.name]) for one in arguments()}
    sections(given["config"])  # that it is a parameter file
    namespace = given["namespace"].strip("/")
    if not namespace:
        raise ConfigurationError(f"namespace = {given['namespace']!r}: must be a name")
    record, view = given["record"], given["view"]
    return Options(
        config=given["config"],
        namespaces=tuple(joints(["--params-file", given["config"]])) if namespace == AUTO else (namespace,),
        one_namespace=namespace != AUTO,
        autostart=_BOOLEANS.get(given["autostart"]),
        use_sim_time=_BOOLEANS.get(given["use_sim_time"]),
        log_level=given["log_level"],
        controller=given["controller"] == "true",
        record=record if _BOOLEANS.get(record.lower(), record) else "",
        view=_port(view),
        bus_interface=given["bus_interface"],
        bus_channel=given["bus_channel"],
        on_exit=given["on_exit"],
        frame_prefix=given["frame_prefix"],
        robot_description=_BOOLEANS.get(given["robot_description"]),
        rviz=given["rviz"] == "true",
    )


def check_names(given: Sequence[str], declared: Collection[str]) -> None:
    """Raise ConfigurationError for `name:=value` whose name is not declared: the launch system would ignore it."""
    for name in (word.partition(":=")[0] for word in given if ":=" in word):
        if name not in declared:
            near = difflib.get_close_matches(name, declared, n=1)
            hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(declared)}"
            raise ConfigurationError(f"{name}: no such argument; {hint}")


def _choice(argument: Argument, value: str) -> str:
    if not argument.choices or value == argument.default:
        return value
    if value.lower() not in argument.choices:
        raise ConfigurationError(f"{argument.name} = {value!r}: must be one of {', '.join(argument.choices)}")
    return value.lower()


def _port(value: str) -> int:
    if value.lower() in _BOOLEANS:
        return VIEW_PORT if _BOOLEANS[value.lower()] else 0
    if not value.isdigit() or not 0 < int(value) < 1 << 16:
        raise ConfigurationError(f"view = {value!r}: must be true, false or a TCP port")
    return int(value)
