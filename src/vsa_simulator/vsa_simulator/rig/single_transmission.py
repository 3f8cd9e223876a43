# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""One transmission without joint and motor: the far end of its tendon follows a motion.

The travel u(t) of that end is twice the commanded deflection plus a constant that balances the elastic force at the
centre, so that the rod follows the motion up to the stretch of its tendon: F = 2 K_t (u - 2 x).
"""

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_simulator.laws.config import ForceLaws
from vsa_simulator.rig.config import TransmissionConfig
from vsa_simulator.rig.motion import Motion, Tone, dwells, position, tones
from vsa_simulator.rig.transmission import (
    Rod,
    Transmission,
    damping,
    elastic_scale,
    rod_rates,
    spring_force,
    stiffness,
    substeps_for,
    transmission_from,
)

COLUMNS = ("time", "deflection", "velocity", "acceleration", "force", "stiffness", "damping", "inertia")
TIME, DEFLECTION, VELOCITY, ACCELERATION, FORCE, STIFFNESS, DAMPING, INERTIA = range(len(COLUMNS))

MOTIONS = {
    "slow": tones(0.010, Tone(0.0075, 0.05)),
    "slow2": tones(0.012, Tone(0.0023, 0.2)),
    "multisine": tones(0.0105, Tone(0.004, 0.05), Tone(0.00016, 0.7, 1.3), Tone(0.00008, 1.7, 2.6)),
    "half_hz": tones(0.009, Tone(0.00105, 0.5)),
    "fast": tones(0.010, Tone(0.0035, 0.07), Tone(0.00035, 1.2, 1.3)),
    "dwells": dwells((0.004, 0.010, 0.014, 0.007, 0.012, 0.005)),
    "one_hz": tones(0.012, Tone(0.00045, 1.0)),
}


def simulate(
    transmission: TransmissionConfig,
    motion: Motion,
    duration: float,
    rate_hz: int,
    laws: ForceLaws = ForceLaws(),  # noqa: B008 (frozen)
) -> Array:
    """Ground truth of `duration` [s] from rest, (samples, len(COLUMNS)), SI."""
    p = transmission_from(transmission, laws)
    substeps = substeps_for(rate_hz, p)
    truth = np.empty((round(duration * rate_hz), len(COLUMNS)))
    _integrate(p, motion, substeps, 1.0 / (rate_hz * substeps), truth)
    return truth


@compiled
def _end_travel(time: float, offset: float, motion: Motion) -> float:
    return offset + 2.0 * position(time, motion)


@compiled
def _tension(x: float, travel: float, p: Transmission) -> float:
    return max(0.0, p.tendon_stiffness * (travel - 2.0 * x))


@compiled
def _rates(rod: Rod, time: float, travel: float, p: Transmission) -> Rod:
    return rod_rates(rod, time, _tension(rod.x, travel, p), p)


@compiled
def _moved(rod: Rod, rate: Rod, time: float) -> Rod:
    """The state after `time` [s] at a constant rate."""
    x, v, z = rod.x + time * rate.x, rod.v + time * rate.v, rod.z + time * rate.z
    return Rod(x, v, z, rod.q + time * rate.q, rod.y + time * rate.y)


@compiled
def _weighted(one: Rod, two: Rod, three: Rod, four: Rod) -> Rod:
    """Weighted sum of the four rates of a step."""
    return Rod(
        one.x + 2.0 * (two.x + three.x) + four.x,
        one.v + 2.0 * (two.v + three.v) + four.v,
        one.z + 2.0 * (two.z + three.z) + four.z,
        one.q + 2.0 * (two.q + three.q) + four.q,
        one.y + 2.0 * (two.y + three.y) + four.y,
    )


@compiled
def _integrate(p: Transmission, motion: Motion, substeps: int, step: float, truth: Array) -> None:
    """Runge-Kutta method of fourth order from rest at the start of the motion; `dynamics` has the whole joint."""
    offset = 0.5 * spring_force(motion.centre, p) / p.tendon_stiffness
    rod, half = Rod(position(0.0, motion), 0.0, 0.0, 0.0, 0.0), 0.5 * step
    end = _end_travel(0.0, offset, motion)
    for row in range(truth.shape[0]):
        for sub in range(substeps):
            time = (row * substeps + sub) * step
            begin = end
            middle, end = _end_travel(time + half, offset, motion), _end_travel(time + step, offset, motion)
            one = _rates(rod, time, begin, p)
            if sub == 0:
                _write_truth(truth[row], time, rod, one.v, begin, p)
            two = _rates(_moved(rod, one, half), time + half, middle, p)
            three = _rates(_moved(rod, two, half), time + half, middle, p)
            four = _rates(_moved(rod, three, step), time + step, end, p)
            rod = _moved(rod, _weighted(one, two, three, four), step / 6.0)


@compiled
def _write_truth(row: Array, time: float, rod: Rod, acceleration: float, travel: float, p: Transmission) -> None:
    """Fill one row of truth, columns as in `COLUMNS`."""
    row[TIME], row[FORCE], row[INERTIA] = time, 2.0 * _tension(rod.x, travel, p), p.inertia
    row[DEFLECTION], row[VELOCITY], row[ACCELERATION] = rod.x, rod.v, acceleration
    row[STIFFNESS], row[DAMPING] = elastic_scale(time, p) * stiffness(rod.x, p), damping(rod.v, p)
