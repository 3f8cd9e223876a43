# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Identification against an independent integration of the paper's rig, which shares no code with vsa_simulator."""

import math
from dataclasses import dataclass, field

import numpy as np
import pytest
from vsa_common.accel import compiled
from vsa_joint.experiment.excitation import (
    FRICTION_LINES,
    PERIOD,
    RESPONSE_LINES,
    largest_multisine,
    low_crest_phases,
    multisine,
)
from vsa_joint.experiment.identification import average, from_motion, from_response, line_response
from vsa_joint.geometry import Joint, TendonPath
from vsa_joint.impedance.reflection import Impedance, response, virtual_work
from vsa_joint.tuning import ANGLE_MAX

RADIUS, JOINT_DAMPING, JOINT_INERTIA = 0.0215, 0.01, 1e-3


@dataclass(frozen=True)
class Law:
    """Coefficients of one transmission."""

    k2: float
    k1: float
    force_offset: float
    d1: float
    d2: float
    inertia: float
    coulomb: float

    def deflection(self, force: float) -> float:
        return math.log((force - self.force_offset) / self.k1) / self.k2

    def stiffness(self, force: float) -> float:
        return self.k2 * (force - self.force_offset)


@dataclass(frozen=True)
class Rig:
    """Both laws and the tendon stiffness [N/m]."""

    tendon: float = 1e5
    friction: bool = True
    laws: tuple[Law, Law] = field(
        default=(
            Law(267.2, 0.776, 16.39, 4000.0, -0.1089e9, 0.3755, 0.3),
            Law(165.6, 7.031, 8.269, 4000.0, -0.1170e9, 0.2295, 0.5),
        )
    )

    def travel(self, force: float) -> np.ndarray:
        """Motor travel [m] that holds both transmissions at `force` [N] and the joint at zero."""
        return np.array([2 * law.deflection(force) + force / (2 * self.tendon) for law in self.laws])

    def run(self, force: float, torque: np.ndarray, rate: float = 1000.0) -> dict[str, np.ndarray]:
        """Motion from rest at `force` [N] under external torque; one row per sample of `torque`."""
        c = 1.0 if self.friction else 0.0
        p = np.array([[w.k2, w.k1, w.force_offset, w.d1, w.d2, w.inertia, c * w.coulomb] for w in self.laws])
        start = np.array([0.0, 0.0, self.laws[0].deflection(force), 0.0, self.laws[1].deflection(force), 0.0])
        substeps = max(1, math.ceil(2e4 / rate))
        states = _integrate(start, torque, self.travel(force), p, self.tendon, 1.0 / rate, substeps)
        tension = [
            self.tendon * (self.travel(force)[i] - s * RADIUS * states[:, 0] - 2 * states[:, 2 + 2 * i])
            for i, s in ((0, 1.0), (1, -1.0))
        ]
        return {
            "angle": states[:, 0],
            "torque": torque,
            "deflection": states[:, [2, 4]],
            "velocity": states[:, [3, 5]],
            "force": 2.0 * np.array(tension).T,
        }


@compiled
def _acceleration(x, v, tension, p):
    k2, k1, f0, d1, d2, m, d0 = p
    w = math.sqrt(d1 / (3.0 * abs(d2)))
    c = min(max(v, -w), w)
    return (2.0 * tension - f0 - k1 * math.exp(k2 * x) - d1 * c - d2 * c**3 - d0 * math.tanh(v / 1.5e-4)) / m


@compiled
def _rate(y, torque, q, p, kt):
    t1 = kt * (q[0] - RADIUS * y[0] - 2.0 * y[2])
    t2 = kt * (q[1] + RADIUS * y[0] - 2.0 * y[4])
    out = np.empty(6)
    out[0] = y[1]
    out[1] = (RADIUS * (t1 - t2) + torque - JOINT_DAMPING * y[1]) / JOINT_INERTIA
    out[2] = y[3]
    out[3] = _acceleration(y[2], y[3], t1, p[0])
    out[4] = y[5]
    out[5] = _acceleration(y[4], y[5], t2, p[1])
    return out


@compiled
def _integrate(y, torque, q, p, kt, dt, substeps):
    out = np.empty((len(torque), 6))
    h = dt / substeps
    for k in range(len(torque)):
        out[k] = y
        end = torque[k + 1] if k + 1 < len(torque) else torque[k]
        for i in range(substeps):
            a = torque[k] + (end - torque[k]) * i / substeps
            b = torque[k] + (end - torque[k]) * (i + 1) / substeps
            k1 = _rate(y, a, q, p, kt)
            k2 = _rate(y + 0.5 * h * k1, 0.5 * (a + b), q, p, kt)
            k3 = _rate(y + 0.5 * h * k2, 0.5 * (a + b), q, p, kt)
            k4 = _rate(y + h * k3, b, q, p, kt)
            y = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return out


def geometry(tendon):
    return Joint((TendonPath(RADIUS, tendon), TendonPath(RADIUS, tendon)), JOINT_DAMPING, JOINT_INERTIA)


def transmissions(rig, force):
    return tuple(Impedance(law.stiffness(force), law.d1, law.inertia) for law in rig.laws)


def observed(rig, force, torque, noise):
    """Mean of two periods of angle and torque after a discarded one, the true impedances at the mean deflections."""
    rate = 200.0
    time = np.arange(round(3 * PERIOD * rate)) / rate
    out = rig.run(force, torque(time), rate)
    generator = np.random.default_rng(11)
    first = round(PERIOD * rate)
    angle = out["angle"][first:] + noise[0] * generator.standard_normal(len(time) - first)
    measured = out["torque"][first:] + noise[1] * generator.standard_normal(len(time) - first)
    mean = out["deflection"][first:].mean(axis=0)
    true = tuple(
        Impedance(law.k1 * law.k2 * math.exp(law.k2 * x), law.d1, law.inertia)
        for law, x in zip(rig.laws, mean, strict=True)
    )
    return average(angle, measured, rate, PERIOD), true, out


@pytest.mark.parametrize(("force", "tendon"), [(19.5, 2e6), (30.0, 2e4), (120.0, 1e5)])
def test_with_friction_stiffness_is_within_one_and_damping_within_three_percent(force, tendon):
    rig, joint = Rig(tendon), geometry(tendon)
    torque = largest_multisine(FRICTION_LINES, 3, transmissions(rig, force), joint, 3.4e-3)
    period, true, out = observed(rig, force, torque, (1e-4, 1e-3))
    identified, truth = from_motion(period, joint), virtual_work(true, joint)
    assert identified.impedance.stiffness == pytest.approx(truth.stiffness, rel=0.01)
    assert identified.impedance.damping == pytest.approx(truth.damping, rel=0.03)
    assert abs(identified.impedance.stiffness - truth.stiffness) < 3.0 * identified.std.stiffness
    assert abs(identified.impedance.damping - truth.damping) < 3.0 * identified.std.damping
    assert identified.friction == pytest.approx(0.5 * RADIUS * 0.8, rel=0.2)
    assert np.abs(out["angle"]).max() < 1.1 * ANGLE_MAX


def test_without_friction_response_stiffness_damping_and_inertia_agree_with_the_truth():
    rig, joint = Rig(1e5, friction=False), geometry(1e5)
    torque = multisine(RESPONSE_LINES, 0.02, 1)
    rate = 1000.0
    time = np.arange(round(3 * PERIOD * rate)) / rate
    out = rig.run(50.0, torque(time), rate)
    period = average(out["angle"][20000:], out["torque"][20000:], rate, PERIOD)
    measured, true = line_response(period, RESPONSE_LINES), transmissions(rig, 50.0)
    assert np.abs(measured / response(torque.frequency, true, joint) - 1.0).max() < 0.01
    identified, truth = from_response(torque.frequency, measured, joint).impedance, virtual_work(true, joint)
    assert (identified.stiffness, identified.damping) == pytest.approx((truth.stiffness, truth.damping), rel=0.005)
    assert identified.inertia == pytest.approx(truth.inertia, rel=0.02)


def test_the_response_of_equal_transmissions_is_identified_exactly():
    transmission, joint = Impedance(2000.0, 4000.0, 0.3), geometry(5e4)
    frequency = np.array([0.05, 0.3, 2.0, 9.0, 20.0])
    identified = from_response(frequency, response(frequency, (transmission, transmission), joint), joint).impedance
    truth = virtual_work((transmission, transmission), joint)
    assert (identified.stiffness, identified.damping, identified.inertia) == pytest.approx(
        (truth.stiffness, truth.damping, truth.inertia), rel=1e-6
    )


def test_insufficient_motion_raises_with_advice():
    at_rest = average(1e-6 * np.ones(4000), np.zeros(4000), 200.0, PERIOD)
    with pytest.raises(ValueError, match="use more torque"):
        from_motion(at_rest, geometry(1e5))


def test_less_than_a_period_raises():
    with pytest.raises(ValueError, match="expected a period"):
        average(np.zeros(100), np.zeros(100), 200.0, PERIOD)


def test_the_phases_have_a_lower_crest_factor_than_random_ones():
    lines = FRICTION_LINES
    time = np.arange(0.0, PERIOD, 0.01)
    waves = 2.0 * np.pi * np.outer(time, np.array(lines) / PERIOD)
    chosen = np.abs(np.cos(waves + np.array(low_crest_phases(lines, 5))).sum(axis=1)).max()
    generator = np.random.default_rng(0)
    others = [np.abs(np.cos(waves + generator.uniform(0, 7, len(lines))).sum(axis=1)).max() for _ in range(50)]
    assert chosen < np.quantile(others, 0.05)


def test_a_multisine_has_the_given_rms():
    torque = multisine(RESPONSE_LINES, 0.02, 2)
    assert torque(np.arange(0.0, PERIOD, 1e-3)).std() == pytest.approx(0.02, rel=1e-3)
    assert torque.rms == pytest.approx(0.02)
