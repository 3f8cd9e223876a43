# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""analyzers.yaml: every task of the suite is in exactly one group of the aggregated diagnostics."""

from pathlib import Path

import pytest
import yaml
from vsa_driver import health as driver
from vsa_estimator.ros.health import ESTIMATION
from vsa_joint.controller_node import CONTROL
from vsa_joint.excitation_node import EXCITATION
from vsa_joint.node import IMPEDANCE
from vsa_simulator.node import SIMULATION
from vsa_tools.record.command import RECORDING

FILE = Path(__file__).parents[2] / "src" / "vsa_bringup" / "config" / "analyzers.yaml"
TASKS = {
    "driver": (*driver.tasks(("transmission_1", "transmission_2")), "topics"),
    "estimator_1": (ESTIMATION, "topics"),
    "estimator_2": (ESTIMATION, "topics"),
    "joint": (IMPEDANCE, "topics"),
    "stiffness_controller": (CONTROL, "topics"),
    "excitation": (EXCITATION, "topics"),
    "recorder": (RECORDING, "topics"),
    "rig_simulator": (SIMULATION, "topics"),
}
DOCUMENT = Path(__file__).parents[2] / "docs" / "reference" / "interfaces.md"


@pytest.mark.parametrize("node", TASKS)
def test_every_status_is_in_one_group_and_documented(node):
    groups = yaml.safe_load(FILE.read_text())["analyzers"]["ros__parameters"]
    prefixes = [group["startswith"] for group in groups.values() if isinstance(group, dict)]
    for task in TASKS[node]:
        name = f"/vsa/{node}: {task}"
        assert sum(any(name.startswith(prefix) for prefix in one) for one in prefixes) == 1
        assert f"`{task}`" in DOCUMENT.read_text()


def test_every_analyzer_is_of_the_generic_kind_with_a_path():
    groups = yaml.safe_load(FILE.read_text())["analyzers"]["ros__parameters"]
    found = [group for group in groups.values() if isinstance(group, dict)]
    assert all(group["type"] == "diagnostic_aggregator/GenericAnalyzer" for group in found)
    assert len({group["path"] for group in found}) == len(found) == 6
