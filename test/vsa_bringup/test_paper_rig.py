# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The parameter file: valid for every node, with the values of the paper."""

import importlib
from pathlib import Path

import pytest
import yaml
from vsa_common.config.configuration import flatten, load

FILE = Path(__file__).parents[2] / "src/vsa_bringup/config/paper_rig.yaml"
NODES = {
    "driver": "vsa_driver.settings.DriverSettings",
    "estimator_1": "vsa_estimator.settings.NodeConfig",
    "estimator_2": "vsa_estimator.settings.NodeConfig",
    "joint": "vsa_joint.settings.JointConfig",
    "recorder": "vsa_tools.record.command.RecorderConfig",
    "stiffness_controller": "vsa_joint.settings.ControlConfig",
    "excitation": "vsa_joint.excitation.settings.ExcitationConfig",
    "rig_simulator": "vsa_simulator.node.SimulatorConfig",
}


def configuration(node: str) -> dict:
    module, _, name = NODES[node].rpartition(".")
    return flatten(load(FILE, node, getattr(importlib.import_module(module), name)))


@pytest.mark.parametrize("node", NODES)
def test_every_section_is_valid_for_its_node(node):
    assert configuration(node)


def test_every_section_belongs_to_a_node():
    assert {key.rsplit("/", 1)[-1] for key in yaml.safe_load(FILE.read_text())} == set(NODES)


@pytest.mark.parametrize(
    ("side", "k2", "force_offset", "d2", "inertia"),
    # eq. (20) in /mm and N; Table I in N s^3/mm^3 and kg
    [(1, 0.2672, 16.39, -0.1089, 0.3755), (2, 0.1656, 8.269, -0.1170, 0.2295)],
)
def test_coefficients_are_those_of_the_paper(side, k2, force_offset, d2, inertia):
    paper = {"k2": k2 * 1e3, "force_offset": force_offset, "d2": d2 * 1e9, "inertia": inertia}
    start, rig = configuration(f"estimator_{side}"), configuration("rig_simulator")
    assert {name: start[f"initial.{name}"] for name in paper} == pytest.approx(paper)
    assert {name: rig[f"transmission_{side}.{name}"] for name in paper} == pytest.approx(paper)


def test_rig_and_suite_have_the_same_bus_geometry_and_calibration():
    driver, joint, rig = (configuration(node) for node in ("driver", "joint", "rig_simulator"))
    for name in ("interface", "channel", "options"):
        assert driver[f"bus.{name}"] == rig[f"bus.{name}"]
    for i in (0, 1):
        side = f"transmission_{i + 1}"
        zero = -rig["sensors.encoder_start"] * rig["sensors.deflection_resolution"]
        assert driver[f"{side}.encoder_offset"] == pytest.approx(zero)
        assert driver[f"{side}.encoder_scale"] == rig["sensors.deflection_resolution"]
        assert joint["radius"][i] == rig["joint.radius"]
        assert joint["tendon_stiffness"][i] == rig[f"{side}.tendon_stiffness"]
    assert joint["joint_damping"] == rig["joint.damping"]
    assert joint["joint_inertia"] == rig["joint.inertia"]
