"""What a demo does besides: one of `SCENARIOS`, a module with a class `Scenario` derived from this one."""

import argparse
import importlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rclpy.node import Node
from vsa_tools.demo.harness import ProcessSpec

SCENARIOS = {"faults": "vsa_tools.scenarios.faults", "stiffness_steps": "vsa_tools.scenarios.stiffness_steps"}


class ScenarioError(ValueError):
    """There is no such scenario."""


class Scenario:
    """The plain demo: the rig moves by its profile, nothing else happens. Override what shall be otherwise."""

    composed = False  # whether driver, estimators and joint share a process, as for fast control

    def __init__(self, options: argparse.Namespace) -> None:
        self.options = options  # of the demo: duration [s], rate [Hz], seed, out

    def parameters(self) -> Mapping[str, Mapping[str, Any]]:
        """Parameters by bare node name that are laid over those of the demo, groups nested."""
        return {}

    def parts(self) -> Sequence[ProcessSpec]:
        """Nodes besides those of the demo; they are active before the rig's clock starts."""
        return ()

    def begin(self, node: Node) -> None:
        """The rig's clock has just started. `node`, in the suite's namespace, is spun while the demo runs."""

    def evaluate(self, folder: Path) -> dict[str, Any]:
        """Figures for summary.json under "scenario"; `folder` holds bag and truth.csv. Tables may be shown here."""
        return {}


def scenario_names() -> list[str]:
    """Those that there are."""
    return sorted(SCENARIOS)


def load_scenario(name: str, options: argparse.Namespace) -> Scenario:
    """The scenario `name`, the plain demo for "". Raises ScenarioError where there is none."""
    if not name:
        return Scenario(options)
    if name not in scenario_names():
        raise ScenarioError(f"no scenario {name!r}; there are: {', '.join(scenario_names()) or 'none'}")
    module = importlib.import_module(SCENARIOS[name])
    return module.Scenario(options)
