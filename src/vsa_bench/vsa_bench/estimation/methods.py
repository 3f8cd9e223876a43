# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Methods of the bench: each computes a track from recordings and start values."""

import time
from collections.abc import Callable

import numpy as np
from vsa_bench.estimation.recordings import Recording
from vsa_bench.estimation.starts import Start
from vsa_bench.estimation.track import Track
from vsa_bench.peers import grioli_bicchi, literal_eq17, menard, recursive_least_squares
from vsa_common.config.configuration import build
from vsa_common.types import Array
from vsa_estimator.formulations import create_estimator
from vsa_estimator.output.estimate import Estimate, State
from vsa_estimator.settings import EstimatorConfig

Method = Callable[[Recording, list[Start]], Track]

ESTIMATE_FIELDS = [
    "stiffness",
    "stiffness_variance",
    "stiffness_valid",
    "damping",
    "damping_variance",
    "damping_valid",
    "inertia",
    "inertia_variance",
    "inertia_valid",
    "k2",
    "k2_variance",
    "d2",
]
COLUMNS = [Estimate._fields.index(name) for name in ESTIMATE_FIELDS]
# ln_stiffness_reference, k2 and d1 within State.coefficient_covariance
NEES_PART = np.ix_([0, 1, 2], [0, 1, 2])


def _estimator(formulation: str) -> Method:
    def run(recording: Recording, starts: list[Start]) -> Track:
        precompile(formulation)
        began = time.process_time()
        runs = [_one_run(formulation, recording, start, row) for row, start in enumerate(starts)]
        seconds = time.process_time() - began
        values = np.array([run[0] for run in runs], dtype=float)
        fields = {name: values[:, :, i] for i, name in enumerate(ESTIMATE_FIELDS)}
        nees = np.array([[_nees(state, recording) for state in run[1]] for run in runs])
        density = float(np.median([state.jerk_density for run in runs for state in run[1]]))
        return Track(**fields, nees=nees, jerk_density=density, seconds=seconds)

    return run


def configuration(formulation: str, recording: Recording, start: Start) -> EstimatorConfig:
    """Parameters of an estimator with the noise of `recording` and the start values `start`."""
    return build(EstimatorConfig, {"formulation": formulation} | recording.noise_parameters() | start.parameters())


def _one_run(
    formulation: str, recording: Recording, start: Start, row: int
) -> tuple[list[tuple[float, ...]], list[State]]:
    estimator = create_estimator(configuration(formulation, recording, start))
    every = round(recording.rate)
    samples = zip(
        recording.stamps_ns.tolist(), recording.force[row].tolist(), recording.deflection[row].tolist(), strict=True
    )
    estimates, states = [], []
    for k, (stamp_ns, force, deflection) in enumerate(samples):
        estimate = estimator.add(stamp_ns, force, deflection)
        if estimate is None:
            raise RuntimeError(f"sample {k} of a simulated recording was dropped")
        estimates.append(tuple(estimate[i] for i in COLUMNS))
        if k % every == every - 1:
            states.append(estimator.state())
    return estimates, states


def _nees(state: State, recording: Recording) -> float:
    """Normalised estimation error squared of [ln_stiffness_reference k2 d1]; its mean is 3 for a consistent filter."""
    c = recording.truth.coefficients
    true = [np.log(c.k1 * c.k2) + c.k2 * state.deflection_reference, c.k2, c.d1]
    error = np.array([state.ln_stiffness_reference, state.k2, state.d1]) - true
    covariance = np.reshape(state.coefficient_covariance, (7, 7))[NEES_PART]
    scale = np.sqrt(np.diag(covariance))
    error = error / scale
    return float(error @ np.linalg.solve(covariance / np.outer(scale, scale) + 1e-9 * np.eye(3), error))


def precompile(formulation: str) -> None:
    """Run an estimator once, so that compilation does not count as computing time."""
    estimator = create_estimator(build(EstimatorConfig, {"formulation": formulation}))
    for k in range(600):
        phase = 2.0 * np.pi * 0.2 * 0.01 * k
        x = 0.010 + 0.003 * np.sin(phase)
        estimator.add(1_000_000_000 + k * 10_000_000, 16.39 + 0.776 * np.exp(267.2 * x) + 15.0 * np.cos(phase), x)


def _literal(recording: Recording, starts: list[Start]) -> Track:
    began = time.process_time()
    state, std = (
        np.array([_eq17_start(start, recording, row, spread) for row, start in enumerate(starts)]) for spread in (0, 1)
    )
    start = literal_eq17.Start(state, std, recording.force_noise, recording.deflection_noise)
    z = literal_eq17.run(recording.force, recording.deflection, recording.rate, start)
    return Track(
        stiffness=z[:, :, 3], damping=z[:, :, 4], inertia=z[:, :, 5], k2=z[:, :, 6], d2=z[:, -1:, 7],
        seconds=time.process_time() - began,
    )  # fmt: skip


def _eq17_start(start: Start, recording: Recording, row: int, spread: int) -> list[float]:
    """Start value (spread 0) or standard deviation (1) of the states of eq. (17)."""
    v, s = start.value, start.std
    force, deflection = recording.force[row, 0], recording.deflection[row, 0]
    stiffness = max(v["k2"] * (force - v["force_offset"]), 1.0)
    if spread:
        return [recording.deflection_noise, 1e-3, 5e-3, 0.7 * stiffness, s["d1"], s["inertia"], s["k2"], s["d2"]]
    return [deflection, 0.0, 0.0, stiffness, v["d1"], v["inertia"], v["k2"], v["d2"]]


def _grioli_bicchi(recording: Recording, starts: list[Start]) -> Track:
    began = time.process_time()
    c = recording.truth.coefficients
    sigma = grioli_bicchi.stiffness(recording.force, recording.deflection, recording.rate, c.d1, c.d2)
    return Track(stiffness=sigma, seconds=time.process_time() - began)


def _fit(peer: Callable[..., tuple[Array, Array, Array]]) -> Method:
    def run(recording: Recording, starts: list[Start]) -> Track:
        began = time.process_time()
        stiffness, damping, d2 = peer(
            recording.force, recording.deflection, recording.rate,
            recording.truth.coefficients.maximum_speed, recording.deflection_noise,
        )  # fmt: skip
        return Track(stiffness=stiffness, damping=damping, d2=d2[:, None], seconds=time.process_time() - began)

    return run


METHODS: dict[str, Method] = {
    "force": _estimator("force"),
    "force_rate": _estimator("force_rate"),
    "literal_eq17": _literal,
    "grioli_bicchi": _grioli_bicchi,
    "recursive_least_squares": _fit(recursive_least_squares.fit),
    "menard": _fit(menard.fit),
}
PEERS = ("grioli_bicchi", "recursive_least_squares", "menard")
