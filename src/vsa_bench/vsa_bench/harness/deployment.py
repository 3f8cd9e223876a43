"""Which processes a run has, and the parameter file that they share."""

import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vsa_common.ros.subprocesses import executable
from vsa_tools.demo.harness import ProcessSpec
from vsa_tools.demo.parameters import Layer, base_parameters, write_parameters

RIG_PRIORITY = 50  # where permitted: a real rig is no process that has to wait for others
CONTROLLER_PRIORITY = 60  # likewise: a controller is what the estimates are for
SEPARATE, COMPOSED, ORDINARY = MODES = ("separate", "composed", "ordinary_executor")
REST_S = 0.004  # of threads that take a quarter of a core, where there is none for each


@dataclass(frozen=True)
class Case:
    """One run: how the nodes live, how fast the rig samples, how many joints, for how long."""

    mode: str
    rate_hz: int
    joints: int
    duration_s: float
    nice: int = 0  # of every process; below zero the machine's other work has to wait
    asleep: bool = False  # composed, too, waits for frames asleep, though it has a core of its own

    @property
    def namespaces(self) -> list[str]:
        """One for each joint."""
        return [f"joint_{i}" for i in range(1, self.joints + 1)]


@dataclass(frozen=True)
class Member(ProcessSpec):
    """A node in a namespace, or a process with nodes of several names or namespaces."""

    namespace: str = ""
    node: str = ""
    ordinary: bool = False

    def command(self, parameters: Path) -> list[str]:
        ros = ["--ros-args", "--params-file", str(parameters)]
        ros += ["-r", f"__ns:=/{self.namespace}"] if self.namespace else []
        ros += ["-r", f"__node:={self.node}"] if self.node else []
        if self.ordinary:
            return [sys.executable, "-m", "vsa_bench.live.standard_executor", self.node, *ros]
        return [executable(self.package, self.executable), *ros]


def rigs(case: Case) -> list[Member]:
    """A simulated rig for each joint."""
    return [_member(case, "vsa_simulator", "rig_simulator", "rig_simulator", space) for space in case.namespaces]


def suite(case: Case) -> list[Member]:
    """The processes that are measured: composed one for each joint, separate one driver for all."""
    if case.mode == COMPOSED:
        return [_member(case, "vsa_bringup", "composed", "", space) for space in case.namespaces]
    ordinary = case.mode == ORDINARY
    members = [Member("driver", "vsa_driver", "driver", nice=case.nice, node="driver", ordinary=ordinary)]
    for space in case.namespaces:
        members += [
            _member(case, "vsa_estimator", "estimator", "estimator_1", space, ordinary),
            _member(case, "vsa_estimator", "estimator", "estimator_2", space, ordinary),
            _member(case, "vsa_joint", "joint", "joint", space, ordinary),
        ]
    return members


def _member(case: Case, package: str, executable_name: str, node: str, space: str, ordinary: bool = False) -> Member:
    name = node or executable_name
    name = name if case.joints == 1 else f"{space}_{name}"
    return Member(name, package, executable_name, nice=case.nice, namespace=space, node=node, ordinary=ordinary)


def apart(case: Case) -> tuple[int, list[int]] | None:
    """A core for rigs and subscriber, and one for each joint's process; None where there are too few, or processes."""
    outside, *others = sorted(os.sched_getaffinity(0))
    return (outside, others) if case.mode == COMPOSED and len(others) >= case.joints else None


def write_case(path: Path, case: Case, first_port: int) -> None:
    """The parameter file: the paper's rig for every joint, each on a bus of its own."""
    rig = {
        "rate_hz": case.rate_hz,
        "duration": case.duration_s,
        "autostart_clock": False,
        "realtime": {"priority": RIG_PRIORITY},
    }
    layers: list[Layer] = [base_parameters(), {"rig_simulator": rig}]
    for i, space in enumerate(case.namespaces):
        bus = {"interface": "udp_multicast", "options": ["hop_limit=0", f"port={first_port + i}"]}
        nodes: dict[str, dict[str, Any]] = {"driver": {"bus": bus}, "rig_simulator": {"bus": bus}}
        if places := apart(case):
            nodes["driver"]["realtime"] = {"cores": str(places[1][i]), "busy": not case.asleep}
            nodes["rig_simulator"]["realtime"] = {"cores": str(places[0])}
        elif case.mode != ORDINARY:
            for node in ("driver", "estimator_1", "estimator_2", "joint"):
                nodes.setdefault(node, {})["realtime"] = {"rest": REST_S}
        layers.append({f"/{space}/{node}": values for node, values in nodes.items()})
    write_parameters(path, *layers)
