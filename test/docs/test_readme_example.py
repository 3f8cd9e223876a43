# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The subscriber example of the README, run as a process."""

import os
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest
import rclpy
from rclpy.signals import SignalHandlerOptions
from vsa_msgs.msg import JointImpedance
from vsa_tools.demo.isolation import claim_domain

pytestmark = pytest.mark.live

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "subscribe.py"


def test_the_readme_shows_the_example():
    code = re.sub(r"\A# Copyright.*\n", "", EXAMPLE.read_text())
    assert f"```python\n{code}```" in (ROOT / "README.md").read_text()


def test_the_example_prints_valid_stiffness_with_its_interval(monkeypatch, tmp_path):
    domain = claim_domain()
    for name, value in domain.environment().items():
        monkeypatch.setenv(name, value)
    printed = tmp_path / "output.txt"
    with printed.open("w") as output:
        example = subprocess.Popen([sys.executable, str(EXAMPLE)], stdout=output, env=os.environ)
    context = rclpy.Context()
    rclpy.init(context=context, args=[], signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = rclpy.create_node("joint", namespace="vsa", context=context)
        publisher = node.create_publisher(JointImpedance, "joint_impedance", 10)
        end = time.monotonic() + 60.0
        while not printed.read_text():
            assert example.poll() is None
            assert time.monotonic() < end
            publisher.publish(JointImpedance(stiffness=1.0, stiffness_valid=False))
            publisher.publish(JointImpedance(stiffness=2.5, stiffness_variance=0.0001, stiffness_valid=True))
            time.sleep(0.02)
    finally:
        example.kill()
        rclpy.shutdown(context=context)
    assert set(printed.read_text().splitlines()) == {"K = 2.500 +- 0.020 N m/rad"}
