"""`./vsa demo --scenario faults`: a lab's rehearsal of faults, and what the suite said of each."""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from ament_index_python.packages import get_package_share_directory
from vsa_common.config.configuration import load
from vsa_common.io.bags import read
from vsa_common.io.tables import read_columns
from vsa_common.stamps import nanoseconds
from vsa_common.terminal import show_table
from vsa_msgs.msg import TransmissionImpedance
from vsa_simulator.faults.failure import Failure, scenario
from vsa_simulator.node import SimulatorConfig
from vsa_tools.evaluation.run_summary import geometry
from vsa_tools.evaluation.summary import Frames, joint_truth
from vsa_tools.scenarios import fault_evaluation as rehearsal
from vsa_tools.scenarios.scenario import Scenario as PlainScenario
from vsa_tools.topics import TRANSMISSIONS

TRUTH = ("stiffness_1", "stiffness_2", "damping_1", "damping_2")


class Scenario(PlainScenario):
    """Injects the faults of the scenario file that comes with the simulated rig."""

    def __init__(self, options: argparse.Namespace) -> None:
        super().__init__(options)
        self._file = Path(get_package_share_directory("vsa_simulator"), "config", "scenario_faults.yaml")
        events = scenario(yaml.safe_load(self._file.read_text()))
        self._events: list[tuple[float, Failure]] = [(e.at, e.failure) for e in events if e.failure is not None]
        options.duration = max(options.duration, events[-1].at + rehearsal.AFTER_S)

    def parameters(self) -> Mapping[str, Mapping[str, Any]]:
        return {"rig_simulator": {"scenario": str(self._file)}}

    def evaluate(self, folder: Path) -> dict[str, Any]:
        heard = FaultRecording(folder)
        faults = [
            rehearsal.judged(occasion, heard.stamp_ns(occasion.begin), heard.sayings, heard.sources)
            for occasion in rehearsal.occasions(self._events)
        ]
        verdict = rehearsal.verdict(faults)
        _show(faults, verdict)
        return {"faults": faults, "verdict": verdict}


class FaultRecording:
    """What a bag holds that a rehearsal is judged by."""

    def __init__(self, folder: Path) -> None:
        self._rig = load(folder / "parameters.yaml", "rig_simulator", SimulatorConfig)
        self._truth = read_columns(folder / "truth.csv", TRUTH)
        topics = [f"/vsa/{side}/{name}" for side in TRANSMISSIONS for name in ("capture_counters", "impedance")]
        states = [f"/vsa/{side}/estimator_state" for side in TRANSMISSIONS]
        self.sayings: list[rehearsal.Saying] = []
        rows: dict[str, list[tuple[float, ...]]] = {name: [] for name in (*TRANSMISSIONS, "joint")}
        stamps: dict[str, list[int]] = {name: [] for name in rows}
        frames: list[tuple[int, int]] = []
        for topic, _, message in read(folder / "bag", [*topics, *states, "/vsa/joint_impedance", "/diagnostics"]):
            name = topic.split("/")[-2] if topic.count("/") > 2 else "joint"
            if topic == "/diagnostics":
                said = (f"{s.name}: {s.message}" for s in message.status if "rig" not in s.name)
                self._say(nanoseconds(message.header.stamp), *said)
            elif topic.endswith("estimator_state"):
                self._say(nanoseconds(message.header.stamp), f"{name}: {message.reason}")
            elif topic.endswith("capture_counters"):
                stamped = zip((nanoseconds(stamp) for stamp in message.stamp), message.counter, strict=True)
                frames += [(stamp_ns, int(counter)) for stamp_ns, counter in stamped]
            else:
                stamps[name].append(nanoseconds(message.header.stamp))
                valid, well = message.stiffness_valid, message.status == TransmissionImpedance.VALID
                rows[name].append((message.stiffness, message.stiffness_variance, valid, well))
        ordered = np.array(sorted(frames), dtype=np.int64).reshape(-1, 2)
        self._frames = Frames(ordered[:, 0], ordered[:, 1])
        self.sources = {name: self._estimates(name, stamps[name], rows[name]) for name in rows}

    def stamp_ns(self, time: float) -> int:
        """Instant at which the rig's clock showed `time` [s]."""
        sample, rate = time * self._rig.rate_hz, self._rig.rate_hz
        counter = np.maximum.accumulate(self._frames.counter)
        before = max(int(np.searchsorted(counter, sample)) - 1, 0)
        return int(self._frames.stamp_ns[before] + (sample - counter[before]) / rate * 1e9)

    def _say(self, stamp_ns: int, *texts: str) -> None:
        self.sayings += [rehearsal.Saying(stamp_ns, text) for text in texts]

    def _estimates(self, name: str, stamps: list[int], rows: list[tuple[float, ...]]) -> rehearsal.Estimates:
        stamp_ns = np.array(stamps, dtype=np.int64)
        there = stamp_ns <= self._frames.stamp_ns[-1]  # afterwards the rig is silent, and predictions have no truth
        stamp_ns = stamp_ns[there]
        value, variance, valid, well = np.array(rows, dtype=float).reshape(-1, 4)[there].T
        rate = self._rig.rate_hz
        time = rehearsal.rig_time(stamp_ns, self._frames.stamp_ns, self._frames.counter, rate)
        exact = self._frames.samples(stamp_ns)
        sample = np.where(exact >= 0, exact, np.round(time * rate)).astype(int)
        sample = np.clip(sample, 0, len(self._truth["stiffness_1"]) - 1)
        if name == "joint":
            truth, _ = joint_truth(self._truth, (sample, sample), geometry(self._rig))
        else:
            truth = self._truth[f"stiffness_{name[-1]}"][sample]
        std = np.sqrt(np.maximum(variance, 1e-12 * np.maximum(value**2, 1.0)))
        deviations = (value - truth) / std if name == "joint" else np.log(np.maximum(value, 1e-9) / truth) * value / std
        return rehearsal.Estimates(sample / rate, value / truth - 1.0, deviations, valid > 0, well > 0)


def _show(faults: list[dict[str, Any]], verdict: Mapping[str, bool]) -> None:
    def number(value: float | None) -> str:
        return "-" if value is None else f"{value:.2f}"

    rows = [
        [
            f"{one['at_s']:.0f} s", one["failure"], one["named_by"][:70], number(one["named_after_s"]),
            number(one["valid_again_after_s"]), number(one["lying_for_s"]),
        ]
        for one in faults
    ]  # fmt: skip
    asked = f"asked: named within {rehearsal.NAMED_S:g} s, valid again within {rehearsal.VALID_S:g} s of its end, no "
    asked += f"stiffness marked valid that is off by more than {rehearsal.DEVIATIONS:g} standard deviations and "
    asked += f"{100 * rehearsal.OFF:g} % for longer than {rehearsal.LYING_S:g} s: "
    asked += "all met" if all(verdict.values()) else f"not met: {', '.join(k for k, met in verdict.items() if not met)}"
    header = ("at", "fault", "what the suite said", "after, s", "valid again, s", "wrong, s")
    show_table("Faults rehearsed", header, rows, asked, texts=3)
