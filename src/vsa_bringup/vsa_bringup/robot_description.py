# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Robot description (URDF) of one joint for robot_state_publisher, and its display in RViz."""

import importlib.util
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any

import yaml
from ament_index_python.packages import PackageNotFoundError, get_package_prefix, get_package_share_directory
from vsa_bringup.arguments import Options
from vsa_bringup.overrides import frame_prefix, write_parameters
from vsa_bringup.process import Process
from vsa_common.config.configuration import ConfigurationError
from vsa_common.config.sections import parameters_of

PUBLISHER, RVIZ, XACRO = "robot_state_publisher", "rviz2", "xacro"
ROOT_LINK = "base_link"


def description_processes(options: Options, namespace: str) -> list[Process]:
    """robot_state_publisher and RViz of one joint, by the options. Raises ConfigurationError for an absent package."""
    result = []
    absent = [name for name in (PUBLISHER, XACRO) if not _is_installed(name)]
    if options.robot_description and absent:
        raise ConfigurationError(f"robot_description = true: not installed: {', '.join(absent)}")
    if options.robot_description is not False and not absent:
        values: dict[str, Any] = {
            "robot_description": urdf(options.config, namespace),
            "frame_prefix": frame_prefix(options, namespace),
        }
        if options.use_sim_time is not None:
            values["use_sim_time"] = options.use_sim_time
        file = write_parameters({f"/{namespace}/{PUBLISHER}": values})
        result.append(Process(PUBLISHER, PUBLISHER, PUBLISHER, namespace, parameter_files=(file,)))
    if options.rviz:
        if not _is_installed(RVIZ):
            raise ConfigurationError(f"rviz = true: not installed: {RVIZ}")
        words = ("-d", rviz_file(frame_prefix(options, namespace)))
        result.append(Process(RVIZ, RVIZ, RVIZ, namespace, arguments=words))
    return result


def urdf(config: str, namespace: str) -> str:
    """URDF of one joint, with names and geometry of the parameter file; `xacro` must be installed."""
    import xacro  # a package of ROS that an installation may lack

    driver, joint = (parameters_of(config, f"/{namespace}/{node}") for node in ("driver", "joint"))
    values = {"joint_name": driver.get("joint.name")}
    values |= {f"radius_{i}": radius for i, radius in enumerate(joint.get("radius", ()), 1)}
    values["motor_pulley_radius"] = joint.get("motor_pulley_radius")
    given = {name: str(value) for name, value in values.items() if value is not None}
    return xacro.process_file(str(_share("urdf", "joint.urdf.xacro")), mappings=given).toxml()


def rviz_file(prefix: str) -> str:
    """Path of the RViz configuration for frames with a prefix."""
    file = _share("rviz", "joint.rviz")
    if not prefix:
        return str(file)
    tree: dict[str, Any] = yaml.safe_load(file.read_text())
    manager = tree["Visualization Manager"]
    manager["Global Options"]["Fixed Frame"] = prefix + ROOT_LINK
    for display in manager["Displays"]:
        if "TF Prefix" in display:
            display["TF Prefix"] = prefix.rstrip("/")
    with NamedTemporaryFile("w", suffix=".rviz", delete=False) as written:
        yaml.safe_dump(tree, written, default_flow_style=False)
    return written.name


def _share(*parts: str) -> Path:
    return Path(get_package_share_directory("vsa_bringup"), *parts)


def _is_installed(package: str) -> bool:
    """Whether a package of ROS is in the environment; xacro may be a Python package alone."""
    if package == XACRO:
        return importlib.util.find_spec(XACRO) is not None
    try:
        get_package_prefix(package)
    except (PackageNotFoundError, LookupError):
        return False
    return True
