# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Base class of the demo's scenarios: the module that SCENARIOS names defines a derived class `Scenario`."""

import argparse
import importlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rclpy.node import Node
from vsa_tools.demo.harness import ProcessSpec

SCENARIOS = {"faults": "vsa_tools.scenarios.faults", "stiffness_steps": "vsa_tools.scenarios.stiffness_steps"}


class ScenarioError(ValueError):
    """The scenario does not exist."""


class Scenario:
    """The plain demo: the rig moves by its profile. A derived class overrides what differs."""

    composed = False  # whether driver, estimators and joint share a process, for a short control latency

    def __init__(self, options: argparse.Namespace) -> None:
        self.options = options  # of the demo: duration [s], rate [Hz], seed, out

    def parameters(self) -> Mapping[str, Mapping[str, Any]]:
        """Parameters by bare node name that override those of the demo; groups are nested."""
        return {}

    def processes(self) -> Sequence[ProcessSpec]:
        """Processes in addition to those of the demo; they are active before the rig's clock starts."""
        return ()

    def begin(self, node: Node) -> None:
        """Called when the rig's clock starts. `node`, in the suite's namespace, is spun while the demo runs."""

    def evaluate(self, folder: Path) -> dict[str, Any]:
        """Figures for summary.json under "scenario", from bag and truth.csv in `folder`. May print tables."""
        return {}

    def failures(self, figures: Mapping[str, Any]) -> list[str]:
        """A sentence for each requirement that the figures of `evaluate` do not meet; the demo then fails."""
        return []


def scenario_names() -> list[str]:
    """Names of all scenarios."""
    return sorted(SCENARIOS)


def load_scenario(name: str, options: argparse.Namespace) -> Scenario:
    """The scenario `name`; the plain demo for "". Raises ScenarioError for an unknown name."""
    if not name:
        return Scenario(options)
    if name not in scenario_names():
        raise ScenarioError(f"no scenario {name!r}; available: {', '.join(scenario_names()) or 'none'}")
    module = importlib.import_module(SCENARIOS[name])
    return module.Scenario(options)
