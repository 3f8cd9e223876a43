# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Robot description of one joint: a tree of links that has the frames of the suite's messages."""

import math
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml
from vsa_bringup.robot_description import ROOT_LINK, rviz_file, urdf
from vsa_tools.topics import OF_A_JOINT, OF_A_TRANSMISSION, TRANSMISSIONS

pytest.importorskip("xacro")

CONFIG = str(Path(__file__).parents[2] / "src/vsa_bringup/config/paper_rig.yaml")
FRAMES = {"joint", "motors", *TRANSMISSIONS}


def robot(config=CONFIG):
    return ElementTree.fromstring(urdf(config, "vsa"))


def numbers(element, attribute):
    return [float(number) for number in element.get(attribute).split()]


def test_links_form_one_tree_and_are_the_frames_of_the_messages():
    tree = robot()
    links = {link.get("name") for link in tree.iter("link")}
    parents = {joint.find("child").get("link"): joint.find("parent").get("link") for joint in tree.findall("joint")}
    assert links == FRAMES | {ROOT_LINK}
    assert parents == dict.fromkeys(FRAMES, ROOT_LINK)


def test_only_the_joint_moves_about_z_as_joint_states_needs():
    moving = [joint for joint in robot().findall("joint") if joint.get("type") != "fixed"]
    assert [(joint.get("name"), joint.get("type")) for joint in moving] == [("joint", "revolute")]
    assert numbers(moving[0].find("axis"), "xyz") == [0.0, 0.0, 1.0]
    limit = moving[0].find("limit")
    assert float(limit.get("lower")) == -float(limit.get("upper")) < 0.0
    assert all(float(limit.get(name)) > 0.0 for name in ("effort", "velocity"))


def test_a_positive_angle_slackens_transmission_1():
    """The point of the pulley at the tendon moves towards the transmission: r x z, along -x at y > 0."""
    mounts = {joint.get("name"): joint.find("origin") for joint in robot().findall("joint")}
    x, y, _ = numbers(mounts["transmission_1_mount"], "xyz")
    velocity_x = -y  # of the point (0, y) at 1 rad/s about z
    assert velocity_x * x > 0.0
    assert numbers(mounts["transmission_2_mount"], "xyz")[1] == -y
    assert numbers(mounts["transmission_1_mount"], "rpy") == pytest.approx(
        [0.0, 0.0, math.pi]
    )  # x: away from the joint


def test_names_and_radii_are_those_of_the_parameter_file(tmp_path):
    file = tmp_path / "rig.yaml"
    file.write_text(
        "/**/driver: {ros__parameters: {joint: {name: elbow}}}\n/**/joint: {ros__parameters: {radius: [0.03, 0.04]}}\n"
    )
    tree = robot(str(file))
    assert {link.get("name") for link in tree.iter("link")} == {"elbow", "motors", *TRANSMISSIONS, ROOT_LINK}
    mounts = {
        joint.get("name"): joint.find("origin") for joint in tree.findall("joint") if joint.get("type") == "fixed"
    }
    assert [numbers(mounts[f"transmission_{i}_mount"], "xyz")[1] for i in (1, 2)] == [0.03, -0.04]


@pytest.mark.parametrize(("prefix", "expected"), [("", ""), ("left/", "left")])
def test_rviz_shows_the_description_and_topics_of_the_suite(prefix, expected):
    manager = yaml.safe_load(Path(rviz_file(prefix)).read_text())["Visualization Manager"]
    assert manager["Global Options"]["Fixed Frame"] == f"{prefix}{ROOT_LINK}"
    (model,) = [display for display in manager["Displays"] if display["Class"].endswith("/RobotModel")]
    assert (model["TF Prefix"], model["Description Topic"]["Value"]) == (expected, "robot_description")
    topics = {display["Topic"]["Value"] for display in manager["Displays"] if "Topic" in display}
    published = {f"{name}/{topic}" for name in TRANSMISSIONS for topic in OF_A_TRANSMISSION} | OF_A_JOINT.keys()
    assert len(topics) == 3
    assert topics <= published
