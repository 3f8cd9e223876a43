# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parameters that arguments of a launch file set, in a file that has precedence over the parameter file of the rig."""

import hashlib
from collections.abc import Mapping
from tempfile import NamedTemporaryFile
from typing import Any

import yaml
from vsa_bringup.arguments import AUTO, NONE, Options
from vsa_common.config.configuration import flat
from vsa_common.config.joints import DEFAULT
from vsa_common.config.sections import OF_LAUNCH, PARAMETERS, applies, parameters_of, sections
from vsa_driver.can.bus import BusConfig
from vsa_joint.settings import SIMULATED_RECOVERY_AMPLITUDE, JointConfig

MULTICAST = "udp_multicast"
WITH_FRAMES = ("driver", "estimator_1", "estimator_2", "joint")  # nodes with the parameter frame_prefix
ON_THE_BUS = ("driver", "rig_simulator")


def overrides(options: Options, namespace: str, node: str, simulated: bool) -> dict[str, dict[str, Any]]:
    """Parameters of one node that the arguments set, by the key of their section; empty without any.

    `simulated`: a namespace has a bus of its own, unless a section of the file for it alone has one, and the controller
    re-excites, unless the file has the amplitude.
    """
    name = f"/{namespace}/{node}"
    given = {"autostart": options.autostart, "use_sim_time": options.use_sim_time}
    values: dict[str, Any] = {key: value for key, value in given.items() if value is not None}
    prefix = frame_prefix(options, namespace)
    if node in WITH_FRAMES and (prefix or options.frame_prefix != AUTO):
        values["frame_prefix"] = prefix
    if node == "joint":
        values |= _joint_name(options, namespace)
    if node in ON_THE_BUS:
        values |= _bus(options, namespace, node, simulated)
    if node == "stiffness_controller" and simulated:
        values |= _recovery(options, name)
    return {_last_key(options.config, name): values} if values else {}


def frame_prefix(options: Options, namespace: str) -> str:
    """Prefix of the frames of one joint: the argument, that of its driver in the parameter file, or its namespace."""
    if options.frame_prefix != AUTO:
        return "" if options.frame_prefix == NONE else options.frame_prefix
    configured = parameters_of(options.config, f"/{namespace}/driver").get("frame_prefix", "")
    return str(configured) or ("" if namespace == DEFAULT else f"{namespace}/")


def write_parameters(tree: Mapping[str, Mapping[str, Any]]) -> str:
    """Path of a new parameter file with these parameters, by the keys of their sections."""
    sections_of_file = {key: {PARAMETERS: dict(values)} for key, values in tree.items()}
    with NamedTemporaryFile("w", prefix=OF_LAUNCH, suffix=".yaml", delete=False) as file:
        yaml.safe_dump(sections_of_file, file, default_flow_style=False)
    return file.name


def bus_channel(namespace: str) -> str:
    """Multicast group of a simulated joint: one for each namespace, of the organization's scope (RFC 2365)."""
    if namespace == DEFAULT:
        return BusConfig().channel
    first, second, third = hashlib.sha256(namespace.encode()).digest()[:3]
    return f"239.{192 + first % 4}.{second}.{third}"


def _bus(options: Options, namespace: str, node: str, simulated: bool) -> dict[str, Any]:
    configured = parameters_of(options.config, f"/{namespace}/{node}")
    interface = configured.get("bus.interface", BusConfig().interface)
    values: dict[str, Any] = {}
    if options.bus_interface:
        values["bus.interface"] = options.bus_interface
        if options.bus_interface != interface:
            values["bus.options"] = list(BusConfig().options) if options.bus_interface == MULTICAST else [""]
    if options.bus_channel:
        values["bus.channel"] = options.bus_channel
    elif simulated and (options.bus_interface or interface) == MULTICAST and not _has_own_bus(options, namespace, node):
        values["bus.channel"] = bus_channel(namespace)
    return values


def _recovery(options: Options, name: str) -> dict[str, Any]:
    """Re-excitation of a simulated joint, unless the file has its amplitude."""
    given = "recovery_amplitude" in parameters_of(options.config, name)
    return {} if given else {"recovery_amplitude": SIMULATED_RECOVERY_AMPLITUDE}


def _joint_name(options: Options, namespace: str) -> dict[str, Any]:
    """Name that the file gives to the joint for the driver alone."""
    driver, joint = (parameters_of(options.config, f"/{namespace}/{node}") for node in ("driver", "joint"))
    name = driver.get("joint.name", JointConfig().joint_name)
    return {} if joint.get("joint_name", JointConfig().joint_name) == name else {"joint_name": name}


def _has_own_bus(options: Options, namespace: str, node: str) -> bool:
    """Whether the file gives a bus to this node of this namespace alone; the default namespace has that of the file."""
    own = flat(sections(options.config).get(f"/{namespace}/{node}", {}))
    return namespace == DEFAULT or not own.keys().isdisjoint(("bus.channel", "bus.options"))


def _last_key(config: str, node: str) -> str:
    """Key that selects `node` and is not in the file: rcl applies sections in the order of their first appearance."""
    space, _, name = node.rpartition("/")
    keys = (node, f"/**/{name}", f"{space}/*", f"{space}/**")
    return next((key for key in keys if key not in sections(config) and applies(key, node)), node)
