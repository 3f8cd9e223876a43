# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""One case: its simulated recordings through the estimator and the peers."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from vsa_bench.estimation.cases import RIGS
from vsa_bench.estimation.starts import wrong_start
from vsa_bench.mismatch.cases import DEFAULT_LAW, Case
from vsa_bench.mismatch.drawn import DrawnCase
from vsa_bench.mismatch.metrics import (
    DAMPING_FLOOR,
    SCORED_FROM,
    Estimates,
    aggregate,
    peer_error,
    quantity_figures,
    settling,
)
from vsa_bench.peers import grioli_bicchi, menard, recursive_least_squares
from vsa_common.config.configuration import build
from vsa_common.types import Array
from vsa_estimator.filter.records import Record
from vsa_estimator.formulations import create_estimator
from vsa_estimator.settings import EstimatorConfig
from vsa_simulator.rig.recording import Recording, Simulation

NOMINAL = RIGS["paper"]["transmission_1"]  # coefficients of the transmission whose laws are replaced
PEERS = ("recursive_least_squares", "menard", "grioli_bicchi")


def run_case(case: Case | DrawnCase, seeds: Sequence[int], seconds: float) -> dict[str, Any]:
    """Figures of each seed and their aggregate, as the JSON has them."""
    simulation = Simulation(case.variant, case.profile, seconds, case.rate_hz)
    recordings = [simulation.recording(seed) for seed in seeds]
    peers = peer_stiffness(recordings, case)
    runs = []
    for row, (seed, recording) in enumerate(zip(seeds, recordings, strict=True)):
        rows = estimate(recording, start_parameters(simulation, seed), case.elastic_law)
        figures = run_figures(rows, simulation)
        scored = simulation.time >= SCORED_FROM * simulation.time[-1]
        figures["peers"] = {
            name: peer_error(stiffness[row, scored], simulation.stiffness[scored]) for name, stiffness in peers.items()
        }
        runs.append(figures)
    return {
        "case": case.name,
        "group": case.group,
        "motion": case.motion,
        "rate_hz": case.rate_hz,
        "seeds": list(seeds),
        "runs": runs,
        "median": aggregate(runs),
    }


def start_parameters(simulation: Simulation, seed: int) -> dict[str, float]:
    """Start values that are wrong by the rule of `bench estimation`, about the true stiffness at the first sample."""
    random = np.random.default_rng([seed, 1])
    return wrong_start(NOMINAL, float(simulation.stiffness[0]), float(simulation.force[0]), random).parameters()


def estimate(recording: Recording, parameters: dict[str, float], elastic_law: str = DEFAULT_LAW) -> Record:
    """Rows of the estimator with the given start values, else in its default configuration; NaN for dropped samples."""
    estimator = create_estimator(build(EstimatorConfig, {**parameters, "elastic_law": elastic_law}))
    return estimator.add_many(recording.stamp_ns, recording.force, recording.deflection)


def run_figures(rows: Record, simulation: Simulation) -> dict[str, Any]:
    """Figures of one run over the samples that were used, the first 30 % excluded."""
    used = np.isfinite(rows["status"])
    scored = used & (simulation.time >= SCORED_FROM * simulation.time[-1])
    stiffness, damping = simulation.stiffness[scored], simulation.damping[scored]
    inertia = np.full(int(scored.sum()), simulation.inertia)
    scale = np.maximum(damping, DAMPING_FLOOR * NOMINAL.d1)
    return {
        "stiffness": quantity_figures(_estimates(rows[scored], "stiffness"), stiffness, stiffness, logarithmic=True),
        "damping": quantity_figures(_estimates(rows[scored], "damping"), damping, scale),
        "inertia": quantity_figures(_estimates(rows[scored], "inertia"), inertia, inertia),
        **settling(rows["stiffness"][used], simulation.stiffness[used], simulation.time[used]),
        "dropped": float(1.0 - np.mean(used)),
    }


def peer_stiffness(recordings: Sequence[Recording], case: Case | DrawnCase) -> dict[str, Array]:
    """Stiffness of each peer, (seeds, samples) [N/m]; they use the sample rate and the nominal data of the damper."""
    force, deflection = (np.array([getattr(one, name) for one in recordings]) for name in ("force", "deflection"))
    rate, noise = float(case.rate_hz), case.variant.sensors.deflection_noise_std
    fits = {"recursive_least_squares": recursive_least_squares.fit, "menard": menard.fit}
    result = {name: fit(force, deflection, rate, NOMINAL.maximum_speed, noise)[0] for name, fit in fits.items()}
    return result | {"grioli_bicchi": grioli_bicchi.stiffness(force, deflection, rate, NOMINAL.d1, NOMINAL.d2)}


def _estimates(rows: Record, name: str) -> Estimates:
    return Estimates(rows[name], rows[f"{name}_variance"], rows[f"{name}_valid"] > 0)
