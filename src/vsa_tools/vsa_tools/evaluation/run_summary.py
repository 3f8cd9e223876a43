# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Content of summary.json from the files of a demo: bag, truth.csv and parameters.yaml."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from vsa_common.config.configuration import flatten, load
from vsa_common.io.tables import read_columns
from vsa_estimator.settings import NodeConfig
from vsa_simulator.laws.dampers import CUBIC
from vsa_simulator.laws.springs import EXPONENTIAL
from vsa_simulator.node import SimulatorConfig
from vsa_simulator.rig.config import TransmissionConfig
from vsa_simulator.rig.transmission import ln_stiffness_slope, transmission_from
from vsa_tools.evaluation.recorded_run import JOINT, NO_SAMPLE, Floats, Integers, RecordedRun
from vsa_tools.evaluation.summary import (
    Coefficient,
    Geometry,
    JointRun,
    Series,
    Transmission,
    joint_summary,
    latency_summary,
    transmission_summary,
)
from vsa_tools.topics import TRANSMISSIONS

TRUTH = tuple(f"{name}_{side}" for side in (1, 2) for name in ("stiffness", "damping"))
COEFFICIENTS = ("k2", "d2", "inertia")
AT_REST = ("deflection_1", "force_1", "deflection_2", "force_2")  # columns of truth for laws other than the paper's
Values = Mapping[str, float]


def summarise(folder: Path, arrivals_ns: Sequence[tuple[int, int]]) -> dict[str, Any]:
    """Content of summary.json for the run whose bag, truth.csv and parameters.yaml are in `folder`.

    `arrivals_ns` are stamp and arrival time [ns] of each joint message at a subscriber.
    Raises BagError, TableError or ConfigurationError where a file cannot be read.
    """
    parameters = folder / "parameters.yaml"
    rig = load(parameters, "rig_simulator", SimulatorConfig)
    paper = rig.spring.kind == EXPONENTIAL and rig.damper.kind == CUBIC
    truth = read_columns(folder / "truth.csv", TRUTH if paper else (*TRUTH, *AT_REST))
    recorded = RecordedRun(folder / "bag")
    transmissions = {}
    for i, (side, true) in enumerate(zip(TRANSMISSIONS, (rig.transmission_1, rig.transmission_2), strict=True), 1):
        start = flatten(load(parameters, f"estimator_{i}", NodeConfig).initial)
        run = _transmission(recorded, side, start, flatten(true))
        if not paper:
            run = _with_other_laws(run, truth, i, rig, start)
        transmissions[side] = transmission_summary(run, truth, i, rig.rate_hz)
    return {
        "rate_hz": rig.rate_hz,
        "duration_s": len(truth["stiffness_1"]) / rig.rate_hz,
        "transmissions": transmissions,
        "joint": joint_summary(_joint(recorded), truth, geometry(rig)),
        "latency_ms": latency_summary(_latencies(recorded, arrivals_ns)),
    }


def geometry(rig: SimulatorConfig) -> Geometry:
    """Geometry between the transmissions and the joint of a simulated rig."""
    sides: tuple[TransmissionConfig, TransmissionConfig] = (rig.transmission_1, rig.transmission_2)
    return Geometry(rig.joint.radius, (sides[0].tendon_stiffness, sides[1].tendon_stiffness), rig.joint.damping)


def _transmission(recorded: RecordedRun, side: str, start: Values, truth: Values) -> Transmission:
    stiffness, damping = _series(recorded, side)
    state = recorded.last_state.get(side)
    coefficients = {name: _coefficient(state, name, start, truth) for name in COEFFICIENTS}
    sample = recorded.frames(side).samples(recorded.estimates(side)["stamp_ns"])
    fused, inertia_valid = (int(state.samples_fused), bool(state.inertia_valid)) if state else (0, False)
    return Transmission(fused, sample, stiffness, damping, coefficients, inertia_valid)


def _with_other_laws(
    run: Transmission, truth: Mapping[str, Floats], side: int, rig: SimulatorConfig, start: Values
) -> Transmission:
    """`run` with stiffness and damping at the last sample among the coefficients, as the laws of `rig` lack others.

    The truth of k2 is the slope of ln(stiffness) at the last sample, that of d2 exists for the paper's damper alone.
    """
    assigned = np.flatnonzero((run.sample >= 0) & (run.sample < len(truth["stiffness_1"])))
    if not len(assigned):
        return run
    last = assigned[-1]
    sample = run.sample[last]
    law = transmission_from((rig.transmission_1, rig.transmission_2)[side - 1], rig)
    slope = ln_stiffness_slope(float(truth[f"deflection_{side}"][sample]), law)
    first = start["k2"] * (truth[f"force_{side}"][0] - start["force_offset"])

    def at_the_end(name: str, series: Series, begin: float) -> Coefficient:
        true = float(truth[f"{name}_{side}"][sample])
        return Coefficient(float(begin), float(series.value[last]), float(series.std[last]), true)

    coefficients = {
        **run.coefficients,
        "k2": replace(run.coefficients["k2"], truth=slope),
        "stiffness": at_the_end("stiffness", run.stiffness, first),
        "damping": at_the_end("damping", run.damping, start["d1"]),
    }
    if rig.damper.kind != CUBIC:
        coefficients["d2"] = replace(run.coefficients["d2"], truth=None)
    return replace(run, coefficients=coefficients)


def _joint(recorded: RecordedRun) -> JointRun:
    stamps = recorded.transmission_stamps()
    first, second = (recorded.frames(side).samples(stamps[:, i]) for i, side in enumerate(TRANSMISSIONS))
    return JointRun((first, second), *_series(recorded, JOINT))


def _series(recorded: RecordedRun, source: str) -> tuple[Series, Series]:
    """Stiffness and damping of a transmission or of the joint."""
    columns = recorded.estimates(source)

    def series(name: str) -> Series:
        return Series(columns[name], np.sqrt(np.maximum(columns[f"{name}_variance"], 0.0)))

    return series("stiffness"), series("damping")


def _coefficient(state: Any, name: str, start: Values, truth: Values) -> Coefficient:
    estimate, variance = (getattr(state, name), getattr(state, f"{name}_variance")) if state else (np.nan, np.nan)
    return Coefficient(start[name], float(estimate), float(np.sqrt(variance)), truth[name])


def _latencies(recorded: RecordedRun, arrivals_ns: Sequence[tuple[int, int]]) -> Integers:
    """Time from the capture of a frame to the first arrival of the joint message with its stamp [ns].

    Messages without a new frame (repeated stamps, predictions without sensor data) have no latency.
    """
    stamp_ns, arrival_ns = np.array(arrivals_ns, dtype=np.int64).reshape(-1, 2).T
    stamp_ns, first = np.unique(stamp_ns, return_index=True)
    arrival_ns = arrival_ns[first]
    of_frame = np.any([recorded.frames(side).samples(stamp_ns) != NO_SAMPLE for side in TRANSMISSIONS], axis=0)
    latency_ns: Integers = (arrival_ns - stamp_ns)[of_frame]
    return latency_ns
