# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`./vsa demo --scenario stiffness_steps`: steps of the commanded stiffness, then pushes by an external torque."""

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
from vsa_common.io.tables import read_columns
from vsa_common.ros.node import RELIABLE, STEADY
from vsa_common.terminal import show_table
from vsa_joint.settings import JointConfig
from vsa_msgs.msg import StiffnessCommand
from vsa_tools.demo.harness import ProcessSpec
from vsa_tools.demo.scenario import Scenario as PlainScenario
from vsa_tools.evaluation.recorded_run import RecordedRun
from vsa_tools.scenarios import stiffness_acceptance as acceptance
from vsa_tools.scenarios import stiffness_plan as plan
from vsa_tools.topics import TRANSMISSIONS

COMMAND_PERIOD_S = 0.02  # well within the controller's command timeout
CONTROL_LOOP = {"realtime": {"nice": -10}}  # where permitted: precedence over the recorder and other load
ARM_LEAD_S = 2.0  # time between arming and the first command
TRUTH = ("time", "angle", "external_torque", "force_1", "force_2", "stiffness_1", "stiffness_2")


class Scenario(PlainScenario):
    """Initializes the estimators, arms the motors, commands by the plan, and evaluates by the rig's truth."""

    composed = True

    def __init__(self, options: argparse.Namespace) -> None:
        super().__init__(options)
        options.duration = max(options.duration, plan.duration())
        self._refused: list[dict[str, Any]] = []

    def parameters(self) -> Mapping[str, Mapping[str, Any]]:
        path = self.options.out.resolve() / "pushes.yaml"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(yaml.safe_dump([{"at": round(p.time, 6), "push": p.torque} for p in plan.pushes()]))
        no_torque = {"amplitudes": [0.0], "frequencies": [1.0], "phases": [0.0]}
        rig = {"scenario": str(path), "torque": no_torque}
        return {"rig_simulator": rig, "driver": CONTROL_LOOP, "stiffness_controller": CONTROL_LOOP}

    def processes(self) -> Sequence[ProcessSpec]:
        return (ProcessSpec("stiffness_controller", "vsa_joint", "stiffness_controller"),)

    def begin(self, node: Node) -> None:
        self._node, self._start, self._armed = node, time.monotonic(), False
        self._publisher = node.create_publisher(StiffnessCommand, "stiffness_command", RELIABLE)
        self._arm = node.create_client(SetBool, "driver/arm")
        node.create_subscription(DiagnosticStatus, "stiffness_controller/status", self._on_status, RELIABLE)
        node.create_timer(COMMAND_PERIOD_S, self._on_time, clock=STEADY)

    def evaluate(self, folder: Path) -> dict[str, Any]:
        truth = read_columns(folder / "truth.csv", TRUTH)
        joint = load(folder / "parameters.yaml", "joint", JointConfig).joint
        recorded = RecordedRun(folder / "bag")
        clock = RigClock(recorded, truth["time"])
        begins = command_times(recorded, clock)
        figures = plan.figures(truth, joint, begins[: len(plan.step_commands())], self._refused)
        figures["reached"] = acceptance.reached(truth["time"], plan.true_stiffness(truth, joint), begins)
        modes = [acceptance.ControlMode(clock.time(one.stamp_ns), one.mode, one.reason) for one in recorded.control]
        figures["holds"] = acceptance.holds(modes, plan.push_commands()[-1].end)
        (folder / "control.json").write_text(json.dumps(figures, indent=2) + "\n")
        _show(figures)
        return figures

    def failures(self, figures: Mapping[str, Any]) -> list[str]:
        return acceptance.failures(figures)

    def _on_time(self) -> None:
        now = time.monotonic() - self._start
        if not self._armed and now > plan.INITIALIZATION_S - ARM_LEAD_S:
            self._armed = True
            self._arm.call_async(SetBool.Request(data=True))
        stiffness = plan.commanded(now)
        if stiffness is None:
            return
        message = StiffnessCommand(stiffness=stiffness)
        message.header.stamp, message.header.frame_id = self._node.get_clock().now().to_msg(), "joint"
        self._publisher.publish(message)

    def _on_status(self, status: DiagnosticStatus) -> None:
        values = {item.key: item.value for item in status.values}
        if values.get("accepted") != "False" or "stiffness_min" not in values:
            return  # accepted, or on hold for another reason
        refusal: dict[str, Any] = {"reason": status.message}
        refusal |= {name: float(values[name]) for name in ("stiffness", "stiffness_min", "stiffness_max")}
        if refusal["stiffness"] not in [one["stiffness"] for one in self._refused]:
            self._refused.append(refusal)


class RigClock:
    """Stamps on the rig's clock, by the first sample captured after each; `rig_time` is that of each sample [s]."""

    def __init__(self, recorded: RecordedRun, rig_time: np.ndarray) -> None:
        self._frames, self._rig_time = recorded.frames(TRANSMISSIONS[0]), rig_time

    def time(self, stamp_ns: int) -> float:
        """Time of a stamp [s]; 0 without samples."""
        frames = self._frames
        if not len(frames.counter):
            return 0.0
        after = int(np.searchsorted(frames.stamp_ns, stamp_ns))
        sample = int(frames.counter[min(after, len(frames.counter) - 1)])
        return float(self._rig_time[min(sample, len(self._rig_time) - 1)])


def command_times(recorded: RecordedRun, clock: RigClock) -> list[float]:
    """Times of the plan's commands on the rig's clock [s]; the planned times where the bag lacks a command."""
    planned = [command.time for command in acceptance.commands()]
    times: list[float] = []
    last = None
    for stamp_ns, stiffness in recorded.commands:
        if stiffness != last and stiffness != plan.UNREACHABLE:
            times.append(clock.time(stamp_ns))
        last = stiffness
    return times if len(times) == len(planned) else planned


def _show(figures: Mapping[str, Any]) -> None:
    rows = [
        [
            f"{s['from']:g} to {s['to']:g}", f"{s['settle_5pct_s']:.2f}", f"{s['equilibrium_steady_mrad']:.1f}",
            f"{s['equilibrium_transient_mrad']:.1f}", f"{100 * s['steady_error']:+.2f}",
        ]
        for s in figures["steps"]
    ]  # fmt: skip
    header = (
        "stiffness, N m/rad", "settling time (5 %), s", "angle at steady state, mrad", "peak angle, mrad",
        "steady error, %",
    )  # fmt: skip
    rendered = ", ".join(f"{one['rendered']:.2f} for {one['commanded']:g}" for one in figures["push_tests"])
    refused = "; ".join(one["reason"] for one in figures["refused"]) or "none"
    steps = figures["reached"]
    in_time = sum(s["reached_s"] is not None and s["reached_s"] <= acceptance.MAX_STEP_S for s in steps)
    held = [one["duration_s"] for one in figures["holds"] if one["mode"] == "holding"]
    excited = sum(one["duration_s"] for one in figures["holds"] if one["mode"] == "exciting")
    tension = f"tension {figures['tension_min_n']:.1f} to {figures['tension_max_n']:.1f} N"
    note = f"Rendered stiffness in push tests: {rendered} N m/rad. Refused commands: {refused}. {tension}. "
    note += f"{in_time} of {len(steps)} commands reached within 5 % in {acceptance.MAX_STEP_S:g} s. "
    note += f"Holds: {len(held)}, the longest {max(held, default=0.0):.1f} s; re-excitation: {excited:.1f} s."
    show_table("Commanded stiffness", header, rows, note)
