# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Recordings behind the golden traces: bench cases, rehearsed faults, disturbed stamps, and one of a live run.

Each is a list of samples (stamp [ns], force [N], deflection [m]) with the estimator's configuration.
"""

import dataclasses
import gzip
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml
from ament_index_python.packages import get_package_share_directory
from vsa_bench.estimation.cases import case
from vsa_bench.estimation.methods import configuration
from vsa_bench.estimation.recordings import record
from vsa_bench.estimation.starts import draw
from vsa_common.config.configuration import build, load
from vsa_driver.acquisition.mapping import load_frames
from vsa_driver.acquisition.router import Router
from vsa_driver.can.bus import Frame
from vsa_driver.settings import DriverSettings
from vsa_estimator.settings import EstimatorConfig, NodeConfig
from vsa_simulator.faults.failure import scenario
from vsa_simulator.faults.injection import Faults
from vsa_simulator.frames import RigFrames
from vsa_simulator.node import SimulatorConfig
from vsa_simulator.rig.rig import Rig
from vsa_tools.demo.parameters import paper_rig
from vsa_tools.topics import TRANSMISSIONS

HERE = Path(__file__).parent
EPOCH_NS = 1_000_000_000_000


class Recording(NamedTuple):
    """Samples of one transmission and how to estimate from them."""

    name: str
    config: EstimatorConfig
    stamps_ns: np.ndarray
    force: np.ndarray
    deflection: np.ndarray


CASES = {
    "multisine": case(motion="multisine"),
    "t2_slow2": case("transmission_2", "slow2"),
    "slow_heavy": case(motion="slow", mass="heavy"),
    "half_hz_heavy": case(motion="half_hz", mass="heavy"),
    "fast": case(motion="fast"),
    "dwells": case(motion="dwells"),
    "other_multisine": case(motion="multisine", rig="other"),
    "t2_slow_noisy": case("transmission_2", "slow", deflection_noise_mm=0.1),
    "multisine_1khz": case(motion="multisine", rate_hz=1000),
    "t2_fast_1khz": case("transmission_2", "fast", rate_hz=1000),
    "force_rate_slow": case(motion="slow", coulomb_friction_n=0.0, start="good"),
    "force_rate_1khz": case(motion="slow", rate_hz=1000, coulomb_friction_n=0.0, start="good"),
}
SECONDS = {"dwells": 80.0, "multisine_1khz": 20.0, "t2_fast_1khz": 16.0, "force_rate_1khz": 6.0}


def of_cases() -> Iterator[Recording]:
    """Cases of `./vsa bench estimation`, one seed each."""
    for seed, (name, one) in enumerate(CASES.items(), 101):
        recording = record(one, [seed], SECONDS.get(name, 40.0))
        start = draw(one, float(recording.truth.deflection[0]), seed)
        formulation = "force_rate" if name.startswith("force_rate") else "force"
        config = configuration(formulation, recording, start)
        yield Recording(name, config, recording.stamps_ns, recording.force[0], recording.deflection[0])


def of_disturbances() -> Iterator[Recording]:
    """A healthy recording with sensors, stamps and values disturbed at known samples."""
    one = case(motion="multisine", rate_hz=200)
    truth = record(one, [7], 30.0)
    start = draw(one, float(truth.truth.deflection[0]), 7)
    config = configuration("force", truth, start)
    for name, disturb in DISTURBANCES.items():
        stamps, force, deflection = truth.stamps_ns.copy(), truth.force[0].copy(), truth.deflection[0].copy()
        stamps, force, deflection = disturb(stamps, force, deflection, np.random.default_rng(3))
        yield Recording(name, config, stamps, force, deflection)


def _late_stamps(stamps, force, deflection, rng):
    """Stamps late by an exponential delay, in order, as those of a busy host."""
    return (
        np.maximum.accumulate(stamps + (3e5 * rng.standard_exponential(stamps.size)).astype(np.int64)),
        force,
        deflection,
    )


def _bursts(stamps, force, deflection, rng):
    """Every 6 s 80 ms of samples arrive together."""
    for begin in range(1800, stamps.size - 20, 1200):
        stamps[begin : begin + 16] = stamps[begin + 16] - np.arange(16, 0, -1) * 40_000
    return stamps, force, deflection


def _encoder_steps(stamps, force, deflection, rng):
    deflection[3200:] += 1e-3
    deflection[4500:] -= 2.5e-3
    return stamps, force, deflection


def _force_drift(stamps, force, deflection, rng):
    force[3000:3800] += np.linspace(0.0, 2.0, 800)
    force[3800:] += 2.0
    return stamps, force, deflection


def _stuck(stamps, force, deflection, rng):
    deflection[3000:3300] = deflection[3000]
    force[4000:4400] = force[4000]
    return stamps, force, deflection


def _noisy(stamps, force, deflection, rng):
    deflection[3000:3400] += 1e-4 * rng.standard_normal(400)
    force[4200:4800] += 0.17 * rng.standard_normal(600)
    return stamps, force, deflection


def _bad_values(stamps, force, deflection, rng):
    force[100], deflection[200], force[300] = np.nan, np.inf, 1e9
    force[3000] += 1.7
    deflection[3300] += 1e-3
    force[3600:3700] = 200.0
    deflection[4000:4040] = 0.02
    stamps[4200], stamps[4300] = 0, stamps[4299]
    return stamps, force, deflection


def _gaps(stamps, force, deflection, rng):
    """Lost samples, silences of 0.1 s to 3 s, a clock set back by an hour."""
    stamps[3000:] += 100_000_000
    stamps[3500:] += 600_000_000
    stamps[4000:] += 3_000_000_000
    stamps[5000:] -= 3_600_000_000_000
    stamps += 7_200_000_000_000
    kept = rng.random(stamps.size) > 0.02
    return stamps[kept], force[kept], deflection[kept]


def _other_rig(stamps, force, deflection, rng):
    """Another transmission from the middle on."""
    one = case(motion="multisine", rate_hz=200, rig="other")
    other = record(one, [8], 30.0)
    return (
        stamps,
        np.where(np.arange(stamps.size) < 3000, force, other.force[0]),
        np.where(np.arange(stamps.size) < 3000, deflection, other.deflection[0]),
    )


DISTURBANCES = {
    "late_stamps": _late_stamps,
    "bursts": _bursts,
    "encoder_steps": _encoder_steps,
    "force_drift": _force_drift,
    "stuck": _stuck,
    "noisy": _noisy,
    "bad_values": _bad_values,
    "gaps": _gaps,
    "other_rig": _other_rig,
}


def of_rehearsals() -> Iterator[Recording]:
    """The faults of the demo from the simulated rig through frames and the driver's router."""
    for rate, seed, seconds in ((200, 63, 157.0), (500, 2, 100.0)):
        samples = _rehearsed(rate, seed, seconds)
        for index, name in enumerate(TRANSMISSIONS, 1):
            config = load(paper_rig(), f"estimator_{index}", NodeConfig)
            columns = [np.array(column) for column in zip(*samples[name], strict=True)]
            yield Recording(f"faults_{rate}hz_{index}", config, *columns)


def _rehearsed(rate: int, seed: int, seconds: float) -> dict[str, list[tuple[int, float, float]]]:
    rng = np.random.default_rng(seed)
    config = load(paper_rig(), "rig_simulator", SimulatorConfig)
    profile = dataclasses.replace(config.profile, phases=tuple(rng.uniform(0.0, 2.0 * np.pi, 3).tolist()))
    rig = Rig(dataclasses.replace(config, seed=seed, rate_hz=rate, profile=profile))
    faults, frames = Faults(rate, config.sensors, seed), RigFrames(load_frames(config.dbc))
    settings = load(paper_rig(), "driver", DriverSettings)
    router = Router(load_frames(settings.dbc), settings)
    file = Path(get_package_share_directory("vsa_simulator"), "config", "scenario_faults.yaml")
    waiting, last_ns = list(scenario(yaml.safe_load(file.read_text()))), 0
    samples: dict[str, list[tuple[int, float, float]]] = {name: [] for name in TRANSMISSIONS}
    for number in range(int(seconds * rate)):
        due_ns = EPOCH_NS + number * 1_000_000_000 // rate
        while waiting and waiting[0].at <= rig.time:
            faults.inject(waiting.pop(0).failure, rig.sample)
        _, _, readings = rig.advance(1)
        faults.expire(number)
        values = faults.readings(readings, number)
        last_ns = max(last_ns, due_ns + 60_000 + int(rng.exponential(60_000)))
        for side in range(2):
            frame = frames.transmission(side, number, values[side], int(values[2 + side]))
            for sent in faults.frames(side + 1, frame, number):
                last_ns += 20_000 + int(rng.exponential(20_000))
                received = Frame(
                    arbitration_id=sent.arbitration_id, data=sent.data, is_extended_id=False, is_error_frame=sent.error
                )
                for sample in router.add(received, last_ns):
                    samples[sample.transmission].append((sample.stamp_ns, sample.force, sample.deflection))
    return samples


def of_a_live_run() -> Iterator[Recording]:
    """Transmission 1 of a live run of stiffness_steps on a busy host, whose stamps are late by 0.3 ms rms."""
    with gzip.open(HERE / "stiffness_steps_false_alarm.csv.gz", "rt") as file:
        stamp, force, deflection, *_ = np.loadtxt(file, delimiter=",", skiprows=1, unpack=True)
    config = build(EstimatorConfig, {"initial.k2": 187.0, "initial.k2_std": 90.0})
    yield Recording("live_stiffness_steps", config, np.round(stamp * 1e9).astype(np.int64), force, deflection)


SOURCES = (of_cases, of_disturbances, of_rehearsals, of_a_live_run)
