# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Processes of a run, and the parameter file that they share."""

import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from vsa_common.ros.subprocesses import executable
from vsa_tools.demo.harness import ProcessSpec
from vsa_tools.demo.parameters import Layer, base_parameters, write_parameters

RIG_PRIORITY = 50  # real-time priority where permitted: a real rig does not compete for a processor
CONTROLLER_PRIORITY = 60  # of the subscriber, in the place of a controller
SEPARATE, COMPOSED, STANDARD_EXECUTOR = MODES = ("separate", "composed", "ordinary_executor")
REST_S = 0.004  # realtime.rest of threads that take a quarter of a core, where there is no core for each [s]


@dataclass(frozen=True)
class Case:
    """One run: deployment of the nodes, rate of the rig, number of joints, duration."""

    mode: str
    rate_hz: int
    joints: int
    duration_s: float
    nice: int = 0  # of every process; below zero they precede the other load of the machine
    asleep: bool = False  # composed blocks while it waits for frames, though it has a core of its own

    @property
    def namespaces(self) -> list[str]:
        """One for each joint."""
        return [f"joint_{i}" for i in range(1, self.joints + 1)]


@dataclass(frozen=True)
class NodeProcess(ProcessSpec):
    """A node in a namespace, or a process with nodes of several names or namespaces."""

    namespace: str = ""
    node: str = ""
    standard_executor: bool = False

    def command(self, parameters: Path) -> list[str]:
        """Command line with the parameter file."""
        ros = ["--ros-args", "--params-file", str(parameters)]
        ros += ["-r", f"__ns:=/{self.namespace}"] if self.namespace else []
        ros += ["-r", f"__node:={self.node}"] if self.node else []
        if self.standard_executor:
            return [sys.executable, "-m", "vsa_bench.live.standard_executor", self.node, *ros]
        return [executable(self.package, self.executable), *ros]


class Cores(NamedTuple):
    """Assignment of processor cores: one for rigs and subscriber, one for the process of each joint."""

    outside: int
    joints: list[int]


def rigs(case: Case) -> list[NodeProcess]:
    """A simulated rig for each joint."""
    return [_process(case, "vsa_simulator", "rig_simulator", "rig_simulator", name) for name in case.namespaces]


def suite(case: Case) -> list[NodeProcess]:
    """The processes under measurement: composed one for each joint, separate one driver for all."""
    if case.mode == COMPOSED:
        return [_process(case, "vsa_bringup", "composed", "", namespace) for namespace in case.namespaces]
    standard = case.mode == STANDARD_EXECUTOR
    processes = [
        NodeProcess("driver", "vsa_driver", "driver", nice=case.nice, node="driver", standard_executor=standard)
    ]
    for namespace in case.namespaces:
        processes += [
            _process(case, "vsa_estimator", "estimator", "estimator_1", namespace, standard),
            _process(case, "vsa_estimator", "estimator", "estimator_2", namespace, standard),
            _process(case, "vsa_joint", "joint", "joint", namespace, standard),
        ]
    return processes


def _process(
    case: Case, package: str, executable_name: str, node: str, namespace: str, standard: bool = False
) -> NodeProcess:
    name = node or executable_name
    name = name if case.joints == 1 else f"{namespace}_{name}"
    return NodeProcess(
        name, package, executable_name, nice=case.nice, namespace=namespace, node=node, standard_executor=standard
    )


def assigned_cores(case: Case) -> Cores | None:
    """Cores of a composed case; None for other modes and where there are too few cores."""
    outside, *others = sorted(os.sched_getaffinity(0))
    return Cores(outside, others) if case.mode == COMPOSED and len(others) >= case.joints else None


def write_case(path: Path, case: Case, first_port: int) -> None:
    """The parameter file: the paper's rig for every joint, each on a bus of its own."""
    rig = {
        "rate_hz": case.rate_hz,
        "duration": case.duration_s,
        "autostart_clock": False,
        "realtime": {"priority": RIG_PRIORITY},
    }
    layers: list[Layer] = [base_parameters(), {"rig_simulator": rig}]
    cores = assigned_cores(case)
    for i, namespace in enumerate(case.namespaces):
        bus = {"interface": "udp_multicast", "options": ["hop_limit=0", f"port={first_port + i}"]}
        nodes: dict[str, dict[str, Any]] = {"driver": {"bus": bus}, "rig_simulator": {"bus": bus}}
        if cores:
            nodes["driver"]["realtime"] = {"cores": str(cores.joints[i]), "busy": not case.asleep}
            nodes["rig_simulator"]["realtime"] = {"cores": str(cores.outside)}
        elif case.mode != STANDARD_EXECUTOR:
            for node in ("driver", "estimator_1", "estimator_2", "joint"):
                nodes.setdefault(node, {})["realtime"] = {"rest": REST_S}
        layers.append({f"/{namespace}/{node}": values for node, values in nodes.items()})
    write_parameters(path, *layers)
