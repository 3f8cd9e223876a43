# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The demo's faults with other motions and rates: rig, frames, router and estimators on a simulated clock."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import yaml
from ament_index_python.packages import get_package_share_directory
from vsa_common.config.configuration import load
from vsa_common.types import Status
from vsa_driver.acquisition.mapping import load_frames
from vsa_driver.acquisition.router import Router
from vsa_driver.can.bus import Frame
from vsa_driver.settings import DriverSettings
from vsa_estimator.estimator import Estimator
from vsa_estimator.settings import NodeConfig
from vsa_simulator.faults.failure import scenario
from vsa_simulator.faults.injection import Faults
from vsa_simulator.frames import RigFrames
from vsa_simulator.node import SimulatorConfig
from vsa_simulator.rig.dynamics import TRUTH
from vsa_simulator.rig.rig import Rig
from vsa_tools.demo.parameters import paper_rig
from vsa_tools.evaluation.recorded_run import Diagnostic
from vsa_tools.scenarios import fault_evaluation as evaluation
from vsa_tools.topics import TRANSMISSIONS

FILE = Path(get_package_share_directory("vsa_simulator"), "config", "scenario_faults.yaml")
SECONDS = 157.0
EPOCH_NS = 1_000_000_000_000
LATENCY_NS, GAP_NS = 60_000, 20_000  # least latency of a frame; least gap between two frames of one instant
REASON_PERIOD_NS = 20_000_000  # between two reads of an estimator's reason


class Suite:
    """Router and estimators with their results and diagnostics."""

    def __init__(self):
        settings = load(paper_rig(), "driver", DriverSettings)
        self._router = Router(load_frames(settings.dbc), settings)
        self._estimators = {
            name: Estimator(load(paper_rig(), name.replace("transmission", "estimator"), NodeConfig))
            for name in TRANSMISSIONS
        }
        self._last_ns = dict.fromkeys(TRANSMISSIONS, 0)
        self.rows = {name: [] for name in TRANSMISSIONS}
        self.diagnostics = []

    def add(self, frame, stamp_ns):
        sent = Frame(
            arbitration_id=frame.arbitration_id, data=frame.data, is_extended_id=False, is_error_frame=frame.error
        )
        for sample in self._router.add(sent, stamp_ns):
            name, estimator = sample.transmission, self._estimators[sample.transmission]
            if (estimate := estimator.add(sample.stamp_ns, sample.force, sample.deflection)) is None:
                continue
            self.rows[name].append((
                sample.sequence, estimate.stiffness, estimate.stiffness_variance, estimate.stiffness_valid,
                estimate.status is Status.VALID,
            ))  # fmt: skip
            if sample.stamp_ns - self._last_ns[name] >= REASON_PERIOD_NS:
                self._last_ns[name] = sample.stamp_ns
                self.diagnostics.append(Diagnostic(sample.stamp_ns, f"{name}: {estimator.state().reason}"))


def evaluated_faults(rate, seed):
    """Figures of each fault of a sensor or of the bus."""
    rng = np.random.default_rng(seed)
    config = load(paper_rig(), "rig_simulator", SimulatorConfig)
    profile = dataclasses.replace(config.profile, phases=tuple(rng.uniform(0.0, 2.0 * np.pi, 3).tolist()))
    rig = Rig(dataclasses.replace(config, seed=seed, rate_hz=rate, profile=profile))
    faults, frames, suite = Faults(rate, config.sensors, seed), RigFrames(load_frames(config.dbc)), Suite()
    events = scenario(yaml.safe_load(FILE.read_text()))
    waiting, begins, truth, last_ns = list(events), {}, [], 0
    for number in range(int(SECONDS * rate)):
        due_ns = EPOCH_NS + number * 1_000_000_000 // rate
        while waiting and waiting[0].at <= rig.time:
            begins[waiting[0].at] = due_ns
            faults.inject(waiting.pop(0).failure, rig.sample)
        _, true, readings = rig.advance(1)
        truth.append(true[0])
        faults.expire(number)
        faulty = faults.readings(readings, number)
        last_ns = max(last_ns, due_ns + LATENCY_NS + int(rng.exponential(LATENCY_NS)))
        for side in range(2):
            frame = frames.transmission(side, number, faulty[side], int(faulty[2 + side]))
            for sent in faults.frames(side + 1, frame, number):
                last_ns += GAP_NS + int(rng.exponential(GAP_NS))
                suite.add(sent, last_ns)
    sources = {name: estimates(np.array(rows, float), np.array(truth), name, rate) for name, rows in suite.rows.items()}
    return [
        evaluation.evaluate_fault(interval, begins[interval.begin], suite.diagnostics, sources)
        for interval in evaluation.fault_intervals([(event.at, event.failure) for event in events])
    ]


def estimates(rows, truth, name, rate):
    number = rows[:, 0].astype(int)
    value, variance, valid, status_valid = rows[:, 1:].T
    ratio = value / truth[number, TRUTH.index(f"stiffness_{name[-1]}")]
    return evaluation.Estimates(
        number / rate, ratio - 1.0, np.log(ratio) * value / np.sqrt(variance), valid > 0, status_valid > 0
    )


@pytest.mark.parametrize(("rate", "seed"), [(100, 1), (200, 63), (200, 70), (200, 75), (500, 2), (500, 3), (1000, 9)])
def test_no_fault_causes_an_undetected_error_and_every_estimate_recovers(rate, seed):
    for one in evaluated_faults(rate, seed):
        assert one["undetected_error_s"] <= evaluation.MAX_UNDETECTED_S, one
        assert one["valid_again_after_s"] is not None, one
        assert one["valid_again_after_s"] <= evaluation.MAX_RECOVERY_S, one
