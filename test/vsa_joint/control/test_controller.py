# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Stiffness control in closed loop with the simulated rig; springs exact, or with a given error."""

import math
from dataclasses import replace

import numpy as np
import pytest
from vsa_joint.control.controller import StiffnessControl
from vsa_joint.control.identified_spring import KnotSpring
from vsa_joint.control.records import Measurement, Target
from vsa_joint.control.springs import ExponentialSpring
from vsa_joint.impedance.reflection import Impedance, virtual_work
from vsa_joint.settings import ControlConfig
from vsa_simulator.rig.config import RigConfig, TorqueConfig
from vsa_simulator.rig.dynamics import TRUTH
from vsa_simulator.rig.rig import Rig

COLUMN = {name: index for index, name in enumerate(TRUTH)}


def rig_config():
    rig = RigConfig()
    return replace(
        rig,
        transmission_2=replace(rig.transmission_2, coulomb_friction=0.5),
        torque=TorqueConfig(amplitudes=(0.0,), frequencies=(1.0,), phases=(0.0,)),
        profile=replace(rig.profile, kind="hold", centre=0.009),
    )


class Loop:
    """Rig and controller at 100 Hz; `k2_error` is the relative error of k2, `second` changes transmission_2."""

    def __init__(self, k2_error=0.0, second=None, **config):
        rig = rig_config()
        self.rig = Rig(replace(rig, transmission_2=replace(rig.transmission_2, **(second or {}))))
        self.control = StiffnessControl(ControlConfig(**config))
        self.springs = tuple(
            ExponentialSpring(
                0.01, math.log(c.k1 * c.k2 * math.exp(c.k2 * 0.01)), c.k2 * (1.0 + k2_error), c.force_offset,
                k2_variance=(0.03 * c.k2) ** 2, damping=c.d1, peak_speed=math.sqrt(c.d1 / (-3.0 * c.d2)),
            )
            for c in (self.rig.config.transmission_1, self.rig.config.transmission_2)
        )  # fmt: skip
        self.rows, self.commands = [], []
        self.read()
        self.control.engage(self.measurement)

    def read(self):
        samples = self.rig.advance(10)
        row = samples.truth[-1]
        true = [
            Impedance(*(row[COLUMN[f"{name}_{n}"]] for name in ("stiffness", "damping", "inertia"))) for n in (1, 2)
        ]
        deflections = [row[COLUMN[f"deflection_{n}"]] for n in (1, 2)]
        estimated = tuple(
            replace(impedance, stiffness=spring.stiffness_at(x))
            for impedance, spring, x in zip(true, self.springs, deflections, strict=True)
        )
        estimate = virtual_work(estimated, self.control.joint)
        self.measurement = Measurement(
            float(samples.readings.angle[-1]), tuple(0.5 * samples.readings.forces[-1]), estimate.stiffness,
            estimate.damping, (row[COLUMN["motor_1"]], row[COLUMN["motor_2"]]), self.springs,
        )  # fmt: skip
        stiffness = virtual_work(tuple(true), self.control.joint).stiffness
        self.rows.append((stiffness, row[COLUMN["angle"]], row[COLUMN["force_1"]], row[COLUMN["force_2"]]))

    def run(self, seconds, stiffness, equilibrium=0.0, push=lambda t: 0.0):
        first = len(self.rows)
        for k in range(round(100 * seconds)):
            self.commands.append(self.control.step(Target(equilibrium, stiffness), self.measurement))
            self.rig.command(*self.commands[-1])
            self.rig.set_disturbance(push(0.01 * k))
            self.read()
        return np.array(self.rows[first:])


def settled_after(rows, stiffness):
    off = np.nonzero(np.abs(rows[:, 0] / stiffness - 1.0) > 0.05)[0]
    return 0.01 * (off[-1] + 1) if len(off) else 0.0


def test_the_first_command_is_the_measured_position():
    loop = Loop()
    target = Target(loop.control.equilibrium, loop.measurement.stiffness)
    assert loop.control.step(target, loop.measurement) == pytest.approx(loop.measurement.motors, abs=0.02)


def test_without_a_reachable_stiffness_the_last_positions_stay():
    loop = Loop()
    loop.run(1.0, 2.0)
    loop.control.reconfigure(ControlConfig(deflection_max=0.001))
    elsewhere = replace(loop.measurement, motors=(0.0, 0.0))
    assert loop.control.step(Target(0.0, 2.0), elsewhere) == loop.commands[-1]


def test_steps_by_two_settle_within_a_second_and_preserve_the_equilibrium():
    loop = Loop()
    loop.run(3.0, 1.0)
    for stiffness in (2.0, 4.0, 2.0, 1.0, 0.5):
        rows = loop.run(4.0, stiffness)
        assert settled_after(rows, stiffness) <= 1.0
        assert np.abs(rows[:, 1]).max() <= 0.030
        assert np.abs(rows[-200:, 1]).max() <= 0.006
        assert rows[:, 2:].min() > 5.0
        assert rows[:, 2:].max() < 190.0


@pytest.mark.parametrize(
    ("second", "config"),
    [
        ({"force_offset": 12.0, "k1": 2.0, "k2": 220.0, "d1": 2500.0, "d2": -5e7}, {}),
        ({"d1": 2500.0}, {}),
        ({"tendon_stiffness": 2e4}, {"tendon_stiffness": (1e5, 2e4)}),
    ],
)
def test_unequal_transmissions_do_not_displace_the_joint(second, config):
    loop = Loop(second=second, **config)
    loop.run(4.0, 1.0)
    for stiffness in (0.5, 4.0, 0.5, 1.0):
        rows = loop.run(5.0, stiffness)
        assert np.abs(rows[:, 1]).max() <= 0.030
        assert np.abs(rows[-150:, 1]).max() <= 0.010
        assert settled_after(rows, stiffness) <= 1.0


def test_a_step_by_eight_settles_within_a_second_and_within_the_speed_of_the_motors():
    loop = Loop()
    loop.run(4.0, 0.5)
    for stiffness in (4.0, 0.5):
        assert settled_after(loop.run(5.0, stiffness), stiffness) <= 1.0
    assert np.abs(np.diff(loop.commands, axis=0)).max() <= 5.0 * 0.01


def test_the_slack_protection_acts_under_a_load_and_not_in_a_fast_motion():
    loop = Loop()
    loop.run(4.0, 1.0)
    rows = loop.run(2.0, 0.5)  # the damper of a shortening transmission bears 9 N: a force below F0, no slack spring
    assert rows[:, 2].min() < 16.39
    assert rows[80:, 2] == pytest.approx(23.3, abs=1.0)
    loaded = loop.run(8.0, 0.5, push=lambda t: 0.2 * min(1.0, t))
    assert loaded[-100:, 2:].mean() > 23.3 + 2.0


@pytest.mark.parametrize("stiffness", [0.5, 1.0, 4.0])
def test_the_rendered_stiffness_is_the_commanded_one(stiffness):
    loop = Loop()
    loop.run(4.0, stiffness)
    torque, angles = 0.1 * stiffness, []
    for sign in (1.0, -1.0):
        rows = loop.run(14.0, stiffness, push=lambda t, sign=sign: sign * torque * min(1.0, 0.5 * t))
        angles.append(rows[-200:, 1].mean())
    assert 2.0 * torque / (angles[0] - angles[1]) == pytest.approx(stiffness, rel=0.1)


def test_the_equilibrium_settles_at_a_commanded_angle():
    loop = Loop()
    loop.run(2.0, 1.0)
    rows = loop.run(4.0, 1.0, equilibrium=0.15)
    assert rows[-100:, 1] == pytest.approx(0.15, abs=0.006)
    assert rows[-100:, 0] == pytest.approx(1.0, rel=0.05)


def knots_of(spring):
    """The law of a spring by knots from 22 N on, which is its least force."""
    knots = tuple(np.linspace(spring.deflection(22.0), 0.016, 8).tolist())
    ln_stiffness = tuple(math.log(spring.stiffness_at(x)) for x in knots)
    damper = {"damping": spring.damping, "peak_speed": spring.peak_speed}
    return KnotSpring(knots, ln_stiffness, (0.0,) * 64, spring.force(knots[0]), **damper)


def test_a_law_with_a_smaller_least_force_after_the_engagement_is_used_down_to_it():
    loop = Loop()
    exponential = loop.springs
    loop.springs = tuple(knots_of(spring) for spring in exponential)
    loop.read()
    loop.control.engage(loop.measurement)
    loop.run(3.0, 1.0)
    loop.springs = exponential
    before = loop.commands[-1]
    rows = loop.run(6.0, 0.35)
    assert np.abs(np.subtract(loop.commands[-600], before)).max() < 0.05
    assert settled_after(rows, 0.35) <= 1.0


def test_an_error_of_three_percent_of_k2_causes_a_few_percent_of_stiffness_error():
    loop = Loop(k2_error=0.03)
    rows = loop.run(5.0, 2.0)
    assert rows[-100:, 0] == pytest.approx(2.0, rel=0.06)


def test_an_unreachable_target_is_refused_with_the_reachable_range():
    loop = Loop()
    feasibility = loop.control.check_command(Target(0.0, 9.0), loop.measurement)
    assert not feasibility.accepted
    assert "reachable: 0.30" in feasibility.text
    assert feasibility.reachable.stiffness_max < 9.0
    assert not loop.control.check_command(Target(0.0, math.nan), loop.measurement).accepted
    assert not loop.control.check_command(Target(3.0, 1.0), loop.measurement).accepted


def test_an_uncertain_k2_causes_a_warning_and_a_larger_uncertainty_a_refusal():
    loop = Loop(error_warn=0.01)
    assert "predicted error" in loop.control.check_command(Target(0.0, 4.0), loop.measurement).text
    loop = Loop(error_warn=0.005, error_max=0.01)
    assert not loop.control.check_command(Target(0.0, 4.0), loop.measurement).accepted


def test_dither_moves_the_transmissions_within_its_limit_and_not_the_joint():
    loop = Loop(dither_amplitude=4e-4, dither_error=0.001)
    loop.run(4.0, 1.0)
    deflections, angles = [], []
    for _ in range(10):
        rows = loop.run(1.0, 1.0)
        deflections += [spring.deflection(f) for spring, f in zip(loop.springs[:1] * 100, rows[:, 2], strict=True)]
        angles += list(rows[:, 1])
    assert loop.control.exciting
    assert 3e-4 < 0.5 * np.ptp(deflections) < 6e-4
    assert np.abs(angles).max() < 0.01
