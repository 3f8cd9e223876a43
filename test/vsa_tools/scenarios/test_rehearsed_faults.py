"""The demo's faults in other motions and at other rates: rig, frames, router and estimators by a clock of their own."""

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
from vsa_tools.scenarios import fault_evaluation as rehearsal
from vsa_tools.topics import TRANSMISSIONS

FILE = Path(get_package_share_directory("vsa_simulator"), "config", "scenario_faults.yaml")
SECONDS = 157.0
EPOCH_NS = 1_000_000_000_000
LATENCY_NS, GAP_NS = 60_000, 20_000  # of a frame, at least; between two that go at once
TOLD_NS = 20_000_000  # between two looks at what an estimator complains of


class Suite:
    """Router and estimators, and what they say of the frames that they get."""

    def __init__(self):
        settings = load(paper_rig(), "driver", DriverSettings)
        self._router = Router(load_frames(settings.dbc), settings)
        self._estimators = {
            name: Estimator(load(paper_rig(), name.replace("transmission", "estimator"), NodeConfig))
            for name in TRANSMISSIONS
        }
        self._looked = dict.fromkeys(TRANSMISSIONS, 0)
        self.rows = {name: [] for name in TRANSMISSIONS}
        self.sayings = []

    def hear(self, frame, stamp_ns):
        sent = Frame(
            arbitration_id=frame.arbitration_id, data=frame.data, is_extended_id=False, is_error_frame=frame.error
        )
        for sample in self._router.add(sent, stamp_ns):
            name, estimator = sample.transmission, self._estimators[sample.transmission]
            if (found := estimator.add(sample.stamp_ns, sample.force, sample.deflection)) is None:
                continue
            self.rows[name].append((
                sample.sequence, found.stiffness, found.stiffness_variance, found.stiffness_valid,
                found.status is Status.VALID,
            ))  # fmt: skip
            if sample.stamp_ns - self._looked[name] >= TOLD_NS:
                self._looked[name] = sample.stamp_ns
                self.sayings.append(rehearsal.Saying(sample.stamp_ns, f"{name}: {estimator.state().reason}"))


def rehearsed(rate, seed):
    """What a rehearsal's judge says of each fault of a sensor or of the bus."""
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
        said = faults.readings(readings, number)
        last_ns = max(last_ns, due_ns + LATENCY_NS + int(rng.exponential(LATENCY_NS)))
        for side in range(2):
            frame = frames.transmission(side, number, said[side], int(said[2 + side]))
            for going in faults.frames(side + 1, frame, number):
                last_ns += GAP_NS + int(rng.exponential(GAP_NS))
                suite.hear(going, last_ns)
    sources = {name: estimates(np.array(rows, float), np.array(truth), name, rate) for name, rows in suite.rows.items()}
    return [
        rehearsal.judged(occasion, begins[occasion.begin], suite.sayings, sources)
        for occasion in rehearsal.occasions([(event.at, event.failure) for event in events])
    ]


def estimates(rows, truth, name, rate):
    number = rows[:, 0].astype(int)
    value, variance, valid, well = rows[:, 1:].T
    ratio = value / truth[number, TRUTH.index(f"stiffness_{name[-1]}")]
    return rehearsal.Estimates(
        number / rate, ratio - 1.0, np.log(ratio) * value / np.sqrt(variance), valid > 0, well > 0
    )


@pytest.mark.parametrize(("rate", "seed"), [(100, 1), (200, 63), (200, 70), (200, 75), (500, 2), (500, 3), (1000, 9)])
def test_no_fault_makes_a_valid_stiffness_wrong_and_all_is_well_again(rate, seed):
    for one in rehearsed(rate, seed):
        assert one["lying_for_s"] <= rehearsal.LYING_S, one
        assert one["valid_again_after_s"] is not None, one
        assert one["valid_again_after_s"] <= rehearsal.VALID_S, one
