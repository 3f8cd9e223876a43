# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`./vsa demo --scenario faults`: injects the faults of scenario_faults.yaml and evaluates their diagnosis."""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from ament_index_python.packages import get_package_share_directory
from vsa_common.config.configuration import load
from vsa_common.io.tables import read_columns
from vsa_common.terminal import show_table
from vsa_simulator.faults.failure import Failure, scenario
from vsa_simulator.node import SimulatorConfig
from vsa_tools.demo.scenario import Scenario as PlainScenario
from vsa_tools.evaluation.recorded_run import JOINT, SOURCES, RecordedRun
from vsa_tools.evaluation.run_summary import geometry
from vsa_tools.evaluation.summary import joint_truth
from vsa_tools.scenarios import fault_evaluation as evaluation
from vsa_tools.topics import TRANSMISSIONS

TRUTH = ("stiffness_1", "stiffness_2", "damping_1", "damping_2")


class Scenario(PlainScenario):
    """Injects the faults of the scenario file that comes with the simulated rig."""

    def __init__(self, options: argparse.Namespace) -> None:
        super().__init__(options)
        self._file = Path(get_package_share_directory("vsa_simulator"), "config", "scenario_faults.yaml")
        events = scenario(yaml.safe_load(self._file.read_text()))
        self._events: list[tuple[float, Failure]] = [(e.at, e.failure) for e in events if e.failure is not None]
        options.duration = max(options.duration, events[-1].at + evaluation.AFTER_LAST_S)

    def parameters(self) -> Mapping[str, Mapping[str, Any]]:
        return {"rig_simulator": {"scenario": str(self._file)}}

    def evaluate(self, folder: Path) -> dict[str, Any]:
        run = FaultRecording(folder)
        faults = [
            evaluation.evaluate_fault(interval, run.stamp_ns(interval.begin), run.diagnostics, run.sources)
            for interval in evaluation.fault_intervals(self._events)
        ]
        acceptance = evaluation.acceptance(faults)
        _show(faults, acceptance)
        return {"faults": faults, "acceptance": acceptance}

    def failures(self, figures: Mapping[str, Any]) -> list[str]:
        return evaluation.failures(figures["faults"])


class FaultRecording:
    """Diagnostics and stiffness errors of the run in `folder` (bag, truth.csv, parameters.yaml)."""

    def __init__(self, folder: Path) -> None:
        self._rig = load(folder / "parameters.yaml", "rig_simulator", SimulatorConfig)
        self._truth = read_columns(folder / "truth.csv", TRUTH)
        recorded = RecordedRun(folder / "bag")
        self._frames = recorded.frames(*TRANSMISSIONS)
        self.diagnostics = recorded.diagnostics
        self.sources = {name: self._estimates(name, recorded.estimates(name)) for name in SOURCES}

    def stamp_ns(self, time: float) -> int:
        """Stamp [ns] of the instant at which the rig's clock shows `time` [s]."""
        sample, rate = time * self._rig.rate_hz, self._rig.rate_hz
        counter = np.maximum.accumulate(self._frames.counter)
        before = max(int(np.searchsorted(counter, sample)) - 1, 0)
        return int(self._frames.stamp_ns[before] + (sample - counter[before]) / rate * 1e9)

    def _estimates(self, name: str, columns: Mapping[str, np.ndarray]) -> evaluation.Estimates:
        # Predictions after the last frame have no truth: the rig is silent.
        kept = columns["stamp_ns"] <= self._frames.stamp_ns[-1]
        fields = ("stamp_ns", "stiffness", "stiffness_variance", "stiffness_valid", "status_valid")
        stamp_ns, value, variance, valid, status_valid = (columns[field][kept] for field in fields)
        rate = self._rig.rate_hz
        time = evaluation.rig_time(stamp_ns, self._frames.stamp_ns, self._frames.counter, rate)
        exact = self._frames.samples(stamp_ns)
        sample = np.where(exact >= 0, exact, np.round(time * rate)).astype(int)
        sample = np.clip(sample, 0, len(self._truth["stiffness_1"]) - 1)
        truth = self._true_stiffness(name, sample)
        std = np.sqrt(np.maximum(variance, 1e-12 * np.maximum(value**2, 1.0)))
        deviations = np.log(np.maximum(value, 1e-9) / truth) * value / std
        return evaluation.Estimates(sample / rate, value / truth - 1.0, deviations, valid > 0, status_valid > 0)

    def _true_stiffness(self, name: str, sample: np.ndarray) -> np.ndarray:
        if name != JOINT:
            return self._truth[f"stiffness_{name[-1]}"][sample]
        stiffness, _ = joint_truth(self._truth, (sample, sample), geometry(self._rig))
        return stiffness


def _show(faults: list[dict[str, Any]], acceptance: Mapping[str, bool]) -> None:
    def number(value: float | None) -> str:
        return "-" if value is None else f"{value:.2f}"

    rows = [
        [
            f"{one['at_s']:.0f} s", one["failure"], one["diagnosed_by"][:70], number(one["diagnosed_after_s"]),
            number(one["valid_again_after_s"]), number(one["undetected_error_s"]),
        ]
        for one in faults
    ]  # fmt: skip
    note = f"acceptance: diagnosed within {evaluation.MAX_DIAGNOSIS_S:g} s and as no other fault, valid again within "
    note += f"{evaluation.MAX_RECOVERY_S:g} s of the end of the fault, no stiffness marked valid with an error above "
    note += f"{evaluation.DEVIATION_THRESHOLD:g} standard deviations and {100 * evaluation.ERROR_THRESHOLD:g} % for "
    note += f"longer than {evaluation.MAX_UNDETECTED_S:g} s: "
    failed = [name for name, met in acceptance.items() if not met]
    note += f"not met: {', '.join(failed)}" if failed else "all met"
    header = ("at", "fault", "diagnostic", "after, s", "valid again, s", "undetected error, s")
    show_table("Injected faults", header, rows, note, texts=3)
