"""`./vsa demo --scenario stiffness_steps`: stiffness steps through its range, the joint stays, a torque pushes."""

import argparse
import json
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node
from std_srvs.srv import SetBool
from vsa_common.config.configuration import load
from vsa_common.io.bags import read
from vsa_common.io.tables import read_columns
from vsa_common.ros.node import RELIABLE, STEADY
from vsa_common.stamps import nanoseconds
from vsa_common.terminal import show_table
from vsa_joint.settings import JointConfig
from vsa_msgs.msg import StiffnessCommand
from vsa_tools.demo.harness import ProcessSpec
from vsa_tools.evaluation.recorded_run import Recorded
from vsa_tools.scenarios import stiffness_plan as plan
from vsa_tools.scenarios.scenario import Scenario as PlainScenario

COMMAND_PERIOD = 0.02  # s
ARMED_BEFORE = 2.0  # s, before the first command
TRUTH = ("time", "angle", "external_torque", "force_1", "force_2", "stiffness_1", "stiffness_2")


class Scenario(PlainScenario):
    """Learns, arms the motors, commands by the plan, and judges by the rig's truth."""

    composed = True

    def __init__(self, options: argparse.Namespace) -> None:
        super().__init__(options)
        options.duration = max(options.duration, plan.duration())
        self._refused: list[dict[str, Any]] = []

    def parameters(self) -> Mapping[str, Mapping[str, Any]]:
        path = self.options.out.resolve() / "pushes.yaml"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(yaml.safe_dump([{"at": round(p.time, 6), "push": p.torque} for p in plan.pushes()]))
        quiet = {"amplitudes": [0.0], "frequencies": [1.0], "phases": [0.0]}
        return {"rig_simulator": {"scenario": str(path), "torque": quiet}}

    def parts(self) -> Sequence[ProcessSpec]:
        return (ProcessSpec("stiffness_controller", "vsa_joint", "stiffness_controller"),)

    def begin(self, node: Node) -> None:
        self._node, self._start, self._armed = node, time.monotonic(), False
        self._publisher = node.create_publisher(StiffnessCommand, "stiffness_command", RELIABLE)
        self._arm = node.create_client(SetBool, "driver/arm")
        node.create_subscription(DiagnosticStatus, "stiffness_controller/status", self._on_status, RELIABLE)
        node.create_timer(COMMAND_PERIOD, self._on_time, clock=STEADY)

    def evaluate(self, folder: Path) -> dict[str, Any]:
        truth = read_columns(folder / "truth.csv", TRUTH)
        joint = load(folder / "parameters.yaml", "joint", JointConfig).joint
        figures = plan.figures(truth, joint, self._begins_of_rig(folder, truth["time"]), self._refused)
        (folder / "control.json").write_text(json.dumps(figures, indent=2) + "\n")
        _show(figures)
        return figures

    def _on_time(self) -> None:
        now = time.monotonic() - self._start
        if not self._armed and now > plan.LEARNING - ARMED_BEFORE:
            self._armed = True
            self._arm.call_async(SetBool.Request(data=True))
        stiffness = plan.commanded(now)
        if stiffness is None:
            return
        message = StiffnessCommand(stiffness=stiffness)
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)

    def _on_status(self, status: DiagnosticStatus) -> None:
        values = {item.key: item.value for item in status.values}
        if values.get("accepted") != "False" or "stiffness_min" not in values:
            return  # taken; or held for another reason
        refusal: dict[str, Any] = {"reason": status.message}
        refusal |= {name: float(values[name]) for name in ("stiffness", "stiffness_min", "stiffness_max")}
        if refusal["stiffness"] not in [one["stiffness"] for one in self._refused]:
            self._refused.append(refusal)

    def _begins_of_rig(self, folder: Path, rig_time: Any) -> list[float]:
        """Instants at which the plan's steps were commanded, on the rig's clock, by its samples' capture stamps.

        The plan's own where the bag does not have them all.
        """
        planned = [command.time for command in plan.step_commands()]
        frames = Recorded(folder / "bag").frames("transmission_1")
        if not len(frames.counter):
            return planned
        out: list[float] = []
        last = None
        for _, _, message in read(folder / "bag", ["/vsa/stiffness_command"]):
            if message.stiffness != last:
                last = message.stiffness
                after = int(np.searchsorted(frames.stamp_ns, nanoseconds(message.header.stamp)))
                sample = int(frames.counter[min(after, len(frames.counter) - 1)])
                out.append(float(rig_time[min(sample, len(rig_time) - 1)]))
        return out[: len(planned)] if len(out) >= len(planned) else planned


def _show(figures: Mapping[str, Any]) -> None:
    rows = [
        [
            f"{s['from']:g} to {s['to']:g}", f"{s['settle_5pct_s']:.2f}", f"{s['equilibrium_steady_mrad']:.1f}",
            f"{s['equilibrium_transient_mrad']:.1f}", f"{100 * s['steady_error']:+.2f}",
        ]
        for s in figures["steps"]
    ]  # fmt: skip
    header = ("stiffness, N m/rad", "within 5 % after, s", "equilibrium off, mrad", "during, mrad", "steady error, %")
    felt = ", ".join(f"{one['rendered']:.2f} for {one['commanded']:g}" for one in figures["felt"])
    refused = "; ".join(one["reason"] for one in figures["refused"]) or "nothing"
    tension = f"tension {figures['tension_min_n']:.1f} to {figures['tension_max_n']:.1f} N"
    show_table("Stiffness commanded", header, rows, f"Felt: {felt} N m/rad. Refused: {refused}. {tension}.")
