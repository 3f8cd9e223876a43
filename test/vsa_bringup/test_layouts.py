# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Every path in the layouts for Foxglove, PlotJuggler and rqt_plot names a number of a published message."""

import json
import os
import re
import subprocess
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from sensor_msgs.msg import JointState
from vsa_msgs.msg import EstimatorState, JointImpedance, TransmissionImpedance

LAYOUTS = Path(__file__).parents[2] / "src" / "vsa_bringup" / "layouts"
TOPICS = {
    **{
        f"/vsa/transmission_{side}/{leaf}": kind
        for side in (1, 2)
        for leaf, kind in (
            ("force", WrenchStamped),
            ("encoder", JointState),
            ("impedance", TransmissionImpedance),
            ("estimator_state", EstimatorState),
        )
    },
    "/vsa/joint_impedance": JointImpedance,
    "/diagnostics": DiagnosticArray,
}
VIEWS = ("force", "position", "velocity", "stiffness", "damping", "inertia", "k2", "d2", "joint", "tension", "status")


def names_a_number(path, separator):
    """Whether "/topic<separator>field" or "...field[2]" names a number of the types in TOPICS."""
    topic, field = next(((t, path[len(t) + 1 :]) for t in TOPICS if path.startswith(t + separator)), (None, ""))
    if topic is None:
        return False
    name, _, index = field.rstrip("]").partition("[")
    kind = TOPICS[topic].get_fields_and_field_types().get(name, "")
    array = re.fullmatch(r"(\w+)\[(\d+)\]|sequence<(\w+)>", kind)
    if array:
        return index.isdigit() and (array[2] is None or int(index) < int(array[2]))
    return not index and kind in {"double", "boolean", "uint8", "uint32", "uint64"}


def foxglove():
    return json.loads((LAYOUTS / "foxglove.json").read_text())


def foxglove_paths():
    for panel in foxglove()["configById"].values():
        yield from (one["value"] for one in panel.get("paths", []))
        if panel.get("xAxisVal") == "custom":
            yield panel["xAxisPath"]["value"]


def plotjuggler_paths():
    for curve in ElementTree.parse(LAYOUTS / "plotjuggler.xml").iter("curve"):
        yield from (curve.attrib[key] for key in ("curve_x", "curve_y") if key in curve.attrib)
        if "curve_x" not in curve.attrib:
            yield curve.attrib["name"]


def rqt_paths(tmp_path, view):
    """Arguments that the script passes to rqt_plot, recorded by a substitute for ros2."""
    ros2 = tmp_path / "ros2"
    ros2.write_text('#!/bin/sh\nprintf "%s\\n" "$@"\n')
    ros2.chmod(0o755)
    environment = os.environ | {"PATH": f"{tmp_path}:{os.environ['PATH']}"}
    command = [LAYOUTS / "rqt_plot.sh", view]
    lines = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout.splitlines()
    assert lines[:3] == ["run", "rqt_plot", "rqt_plot"]
    return lines[3:]


def test_a_path_without_a_field_is_detected():
    assert names_a_number("/vsa/transmission_1/impedance.stiffness", ".")
    assert names_a_number("/vsa/joint_impedance/tension[1]", "/")
    assert not names_a_number("/vsa/transmission_1/impedance.stifness", ".")
    assert not names_a_number("/vsa/joint_impedance/tension[2]", "/")
    assert not names_a_number("/vsa/transmission_3/impedance.stiffness", ".")
    assert not names_a_number("/vsa/joint_impedance.reason", ".")


@pytest.mark.parametrize("path", sorted(set(foxglove_paths())))
def test_paths_of_foxglove_are_published(path):
    assert names_a_number(path, ".")


@pytest.mark.parametrize("path", sorted(set(plotjuggler_paths())))
def test_paths_of_plotjuggler_are_published(path):
    assert names_a_number(path, "/")


@pytest.mark.parametrize("view", VIEWS)
def test_paths_of_rqt_plot_are_published(tmp_path, view):
    paths = rqt_paths(tmp_path, view)
    assert paths
    assert all(names_a_number(path, "/") for path in paths)


def test_foxglove_panels_and_their_positions_match():
    layout = foxglove()

    def placed(node):
        if isinstance(node, str):
            return {node}
        return placed(node["first"]) | placed(node["second"])

    shown = placed(layout["layout"])
    for panel in layout["configById"].values():
        for tab in panel.get("tabs", []):
            shown |= placed(tab["layout"])
    assert shown == set(layout["configById"])


def test_raw_panels_and_diagnostics_subscribe_to_existing_topics():
    for panel in foxglove()["configById"].values():
        for key in ("topicPath", "topicToRender"):
            assert panel.get(key, "/diagnostics") in TOPICS


def test_every_splitter_of_plotjuggler_has_its_number_of_parts():
    splitters = list(ElementTree.parse(LAYOUTS / "plotjuggler.xml").iter("DockSplitter"))
    assert splitters
    for splitter in splitters:
        assert len(splitter) == int(splitter.attrib["count"]) == len(splitter.attrib["sizes"].split(";"))


def test_both_layouts_show_the_quantities_of_figures_7_to_9():
    for paths in (set(foxglove_paths()), {path.replace("impedance/", "impedance.") for path in plotjuggler_paths()}):
        for name in ("force", "deflection", "velocity", "acceleration", "stiffness", "damping", "inertia"):
            assert {f"/vsa/transmission_{side}/impedance.{name}" for side in (1, 2)} <= paths
