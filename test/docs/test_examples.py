# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The gain-scheduling controller of examples/, with joint messages published by the test."""

import importlib.util
import math
import subprocess
import sys
import time
from pathlib import Path

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from vsa_msgs.msg import JointImpedance, StiffnessCommand
from vsa_tools.demo.isolation import claim_domain

pytestmark = pytest.mark.live

EXAMPLE = Path(__file__).parents[2] / "examples" / "schedule_gains.py"


@pytest.fixture(scope="module")
def example():
    spec = importlib.util.spec_from_file_location("schedule_gains", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def joint(stiffness=2.0, std=0.01, valid=True, damping=0.0, damping_valid=False):
    return JointImpedance(
        stiffness=stiffness,
        stiffness_variance=std**2,
        stiffness_valid=valid,
        damping=damping,
        damping_valid=damping_valid,
    )


def test_a_stiffer_joint_needs_a_smaller_displacement_for_the_same_torque(example):
    soft, stiff = (example.schedule(joint(stiffness, std=0.0), None) for stiffness in (0.5, 5.0))
    assert (soft.compliance, stiff.compliance) == (pytest.approx(2.0), pytest.approx(0.2))


def test_uncertainty_reduces_the_compliance_gain(example):
    certain, uncertain = example.schedule(joint(std=0.0), None), example.schedule(joint(std=0.1), None)
    assert uncertain.compliance == pytest.approx(certain.compliance * math.exp(-1.96 * 0.05))


def test_feedback_adds_the_missing_damping(example):
    wanted = 2.0 * 0.7 * math.sqrt(2.0 * example.LINK_INERTIA)
    half = example.schedule(joint(std=0.0, damping=0.5 * wanted, damping_valid=True), None)
    enough = example.schedule(joint(std=0.0, damping=2.0 * wanted, damping_valid=True), None)
    assert half.lead == pytest.approx(0.5 * wanted / 2.0)
    assert enough.lead == 0.0


@pytest.mark.parametrize("bad", [joint(valid=False), joint(std=1.0)])
def test_gains_are_kept_while_the_estimate_is_invalid_or_imprecise(example, bad):
    before = example.Gains(0.5, 0.01)
    assert example.schedule(bad, before) is before
    assert example.schedule(bad, None) is None


def test_the_running_example_commands_the_equilibrium_for_its_torque():
    domain = claim_domain()
    command = [sys.executable, str(EXAMPLE), "--ros-args", "-p", "torque:=0.3", "-p", "stiffness:=1.5"]
    process = subprocess.Popen(command, env=domain.environment(), stderr=subprocess.DEVNULL)
    context = rclpy.Context()
    rclpy.init(context=context, args=[], domain_id=domain.domain, signal_handler_options=SignalHandlerOptions.NO)
    received = []
    try:
        node = rclpy.create_node("joint", namespace="vsa", context=context)
        publisher = node.create_publisher(JointImpedance, "joint_impedance", 10)
        node.create_subscription(StiffnessCommand, "stiffness_command", received.append, 10)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        end = time.monotonic() + 60.0
        while not received:
            assert process.poll() is None
            assert time.monotonic() < end
            publisher.publish(joint(stiffness=2.0, std=0.0))
            executor.spin_once(timeout_sec=0.05)
    finally:
        process.kill()
        process.wait()
        rclpy.shutdown(context=context)
    assert (received[0].equilibrium_angle, received[0].stiffness) == (pytest.approx(0.15), 1.5)
