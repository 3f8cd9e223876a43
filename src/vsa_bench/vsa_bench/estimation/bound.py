# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Posterior Cramer-Rao bound: the least covariance of an unbiased estimator.

P. Tichavsky, C. Muravchik, A. Nehorai, "Posterior Cramer-Rao bounds for discrete-time nonlinear filtering", IEEE Trans.
Signal Processing 46(5), 1998: with Gaussian noise it is the Riccati recursion linearised at the truth. Constant
acceleration with white jerk, constant coefficients, every deflection and every force used, the run's own start
uncertainty and process noise.
"""

from dataclasses import dataclass

import numpy as np
from vsa_bench.estimation.recordings import RESOLUTION, Recording, Truth
from vsa_bench.estimation.starts import Start
from vsa_common.types import Array

COULOMB_SPEED = 0.15e-3  # of the smoothed friction that an estimator can model [m/s]
# States [x v a ln_sigma k2 d1 d2 M F0 d0] in N, mm, s (mass: kg), where their covariance is well conditioned.
TO_SI = np.array([1e-3, 1e-3, 1e-3, 1.0, 1e3, 1e3, 1e9, 1.0, 1.0, 1.0])
START_VELOCITY_MM = 1.0  # standard deviation of the first velocity [mm/s]
START_ACCELERATION_MM = 5.0  # and acceleration [mm/s^2]


@dataclass(frozen=True)
class Bound:
    """Least variances along a recording, (samples,), SI."""

    ln_stiffness: Array
    k2: Array


def equivalent_jerk_density(truth: Truth) -> float:
    """White jerk [m^2/s^5] with the low-frequency power of the true, coloured jerk."""
    dt = truth.time[1] - truth.time[0]
    jerk = np.gradient(truth.acceleration, dt)
    correlation_time = float(np.sqrt(np.mean(truth.acceleration**2) / np.mean(jerk**2)))
    return 2.0 * float(np.mean(jerk**2)) * correlation_time


def force_gradients(truth: Truth) -> Array:
    """Derivatives of the force, eq. (6), by the states at the truth, (samples, 10), SI; reference: the first x."""
    c = truth.coefficients
    dx = truth.deflection - truth.deflection[0]
    sigma = truth.stiffness
    held = np.clip(truth.velocity, -c.maximum_speed, c.maximum_speed)
    friction = np.tanh(truth.velocity / COULOMB_SPEED)
    by_velocity = truth.damping + c.coulomb_friction * (1.0 - friction**2) / COULOMB_SPEED
    ones = np.ones_like(dx)
    elastic = (sigma, by_velocity, c.inertia * ones, sigma / c.k2, sigma / c.k2 * (dx - 1.0 / c.k2))
    return np.stack([*elastic, held, held**3, truth.acceleration, ones, friction], axis=1)


def posterior_bound(recording: Recording, start: Start, jerk_density: float) -> Bound:
    """The bound for the uncertainty of one start, with process noise `jerk_density` [m^2/s^5]."""
    truth = recording.truth
    dt = 1.0 / recording.rate
    deflection_variance = 1e6 * (recording.deflection_noise**2 + RESOLUTION**2 / 12.0)
    std = np.array([start.std[n] for n in ("d1", "d2", "inertia", "force_offset", "coulomb_friction")])
    first = np.array(
        [0.0, START_VELOCITY_MM, START_ACCELERATION_MM, np.log(2.0), start.std["k2"] / TO_SI[4], *(std / TO_SI[5:])]
    )
    p = np.diag(first**2)
    p[0, 0] = deflection_variance
    transition = np.eye(10)
    transition[0, 1], transition[0, 2], transition[1, 2] = dt, dt**2 / 2.0, dt
    noise = np.zeros((10, 10))
    noise[:3, :3] = [
        [dt**5 / 20.0, dt**4 / 8.0, dt**3 / 6.0],
        [dt**4 / 8.0, dt**3 / 3.0, dt**2 / 2.0],
        [dt**3 / 6.0, dt**2 / 2.0, dt],
    ]
    noise *= jerk_density * 1e6
    measured = force_gradients(truth) * TO_SI
    outputs = _outputs(truth) * TO_SI
    result = np.empty((len(measured), len(outputs)))
    position = np.eye(10)[0]
    for k, row in enumerate(measured):
        if k:
            p = transition @ p @ transition.T + noise
        p = _updated(p, position, deflection_variance)
        p = _updated(p, row, recording.force_noise**2)
        result[k] = np.einsum("oi,ij,oj->o", outputs[:, k], p, outputs[:, k])
    return Bound(*result.T)


def _updated(p: Array, row: Array, variance: float) -> Array:
    ph = p @ row
    p = p - np.outer(ph, ph) / (row @ ph + variance)
    return np.asarray(0.5 * (p + p.T))


def _outputs(truth: Truth) -> Array:
    """Gradients of ln sigma and k2 by the states, (2, samples, 10), SI."""
    gradients = np.zeros((2, len(truth.time), 10))
    gradients[0, :, 0] = truth.coefficients.k2
    gradients[0, :, 3] = 1.0
    gradients[0, :, 4] = truth.deflection - truth.deflection[0]
    gradients[1, :, 4] = 1.0
    return gradients
