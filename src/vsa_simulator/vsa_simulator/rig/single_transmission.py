"""One transmission without joint and motor: the far end of its tendon follows a motion.

The travel u(t) of that end is twice the commanded deflection plus a constant that balances the elastic force at the
centre, so that the rod follows the motion up to the stretch of its tendon: F = 2 K_t (u - 2 x).
"""

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_simulator.rig.config import FrictionConfig, TransmissionConfig
from vsa_simulator.rig.motion import Motion, Tone, dwells, position, tones
from vsa_simulator.rig.transmission import (
    Transmission,
    bristle_rate,
    damping,
    rod_acceleration,
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
    friction: FrictionConfig = FrictionConfig(),  # noqa: B008 (frozen)
) -> Array:
    """Ground truth of `duration` [s] from rest, (samples, len(COLUMNS)), SI."""
    p = transmission_from(transmission, friction)
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
def _integrate(p: Transmission, motion: Motion, substeps: int, step: float, truth: Array) -> None:
    """Runge-Kutta method of fourth order from rest at the start of the motion; `dynamics` has the whole joint."""
    offset = 0.5 * spring_force(motion.centre, p) / p.tendon_stiffness
    x, v, z = position(0.0, motion), 0.0, 0.0
    end = _end_travel(0.0, offset, motion)
    for row in range(truth.shape[0]):
        for sub in range(substeps):
            time = (row * substeps + sub) * step
            begin = end
            middle, end = _end_travel(time + 0.5 * step, offset, motion), _end_travel(time + step, offset, motion)
            tension = _tension(x, begin, p)
            a1, b1 = rod_acceleration(x, v, z, tension, p), bristle_rate(v, z, p)
            if sub == 0:
                truth[row, TIME], truth[row, FORCE], truth[row, INERTIA] = time, 2.0 * tension, p.inertia
                truth[row, DEFLECTION], truth[row, VELOCITY], truth[row, ACCELERATION] = x, v, a1
                truth[row, STIFFNESS], truth[row, DAMPING] = stiffness(x, p), damping(v, p)
            x2, v2, z2 = x + 0.5 * step * v, v + 0.5 * step * a1, z + 0.5 * step * b1
            a2, b2 = rod_acceleration(x2, v2, z2, _tension(x2, middle, p), p), bristle_rate(v2, z2, p)
            x3, v3, z3 = x + 0.5 * step * v2, v + 0.5 * step * a2, z + 0.5 * step * b2
            a3, b3 = rod_acceleration(x3, v3, z3, _tension(x3, middle, p), p), bristle_rate(v3, z3, p)
            x4, v4, z4 = x + step * v3, v + step * a3, z + step * b3
            a4, b4 = rod_acceleration(x4, v4, z4, _tension(x4, end, p), p), bristle_rate(v4, z4, p)
            x += step / 6.0 * (v + 2.0 * (v2 + v3) + v4)
            v += step / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)
            z += step / 6.0 * (b1 + 2.0 * (b2 + b3) + b4)
