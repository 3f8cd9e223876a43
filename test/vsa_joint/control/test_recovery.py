# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Control with an invalid stiffness: last valid law, re-excitation, hold; in closed loop with the simulated rig."""

import math
from dataclasses import replace

import numpy as np
import pytest
from vsa_common.types import Status
from vsa_joint.control.mode import Mode
from vsa_joint.control.records import Inputs, JointMeasurement, Target
from vsa_joint.control.springs import ExponentialSpring
from vsa_joint.control.stiffness_range import stiffness_at_forces
from vsa_joint.control.supervisor import Supervisor
from vsa_joint.settings import ControlConfig
from vsa_simulator.rig.config import RigConfig, TorqueConfig
from vsa_simulator.rig.dynamics import TRUTH
from vsa_simulator.rig.rig import Rig

MS, PERIOD = 1_000_000, 0.01
RE_EXCITED = {"recovery_amplitude": 5e-4}
COLUMN = {name: index for index, name in enumerate(TRUTH)}


def law(config, k2_error=0.0, k2_std=0.005):
    """The law of a transmission of the rig, exact at 10 mm of deflection."""
    ln_stiffness = math.log(config.k1 * config.k2 * math.exp(config.k2 * 0.01))
    return ExponentialSpring(
        0.01, ln_stiffness, config.k2 * (1.0 + k2_error), config.force_offset,
        k2_variance=(k2_std * config.k2) ** 2, damping=config.d1, peak_speed=math.sqrt(config.d1 / (-3.0 * config.d2)),
    )  # fmt: skip


class Plant:
    """Rig and supervised controller at 100 Hz.

    `valid` is the validity of the stiffness. With `travel` [m] it returns once each transmission has moved so far since
    `invalidate`; the springs of an invalid estimate are unusable.
    """

    def __init__(self, errors=(0.0, 0.0), **config):
        rig = RigConfig()
        quiet = TorqueConfig(amplitudes=(0.0,), frequencies=(1.0,), phases=(0.0,))
        rig = replace(rig, torque=quiet, profile=replace(rig.profile, kind="hold", centre=0.009))
        self.rig, self.config = Rig(rig), ControlConfig(**config)
        sides = rig.transmission_1, rig.transmission_2
        self.springs = tuple(law(side, error) for side, error in zip(sides, errors, strict=True))
        self.supervisor, self.inputs, self.now = Supervisor(self.config), Inputs(), 0
        self.valid, self.sensor_fault, self.travel = True, False, math.inf
        self.force_error = np.zeros(2)  # of both force sensors [N]
        self._path, self._last = np.zeros(2), None

    def invalidate(self, travel=math.inf):
        self.valid, self.travel, self._path = False, travel, np.zeros(2)

    def run(self, seconds, stiffness, commands=True, push=0.0, equilibrium=0.0):
        """Rows of each period: mode, true stiffness, angle, force_1, force_2, motor_1, motor_2 as commanded."""
        rows = []
        self.rig.set_disturbance(push)
        for _ in range(round(seconds / PERIOD)):
            self.now += 10 * MS
            self.read()
            if commands:
                self.supervisor.command(Target(equilibrium, stiffness), self.inputs, self.now)
            motors = self.supervisor.step(self.inputs, self.now)
            self.rig.command(*motors)
            rows.append((self.supervisor.mode, *self.truth(), *motors))
        return rows

    def read(self):
        samples = self.rig.advance(10)
        self._row, readings = samples.truth[-1], samples.readings
        deflections = samples.truth[:, [COLUMN["deflection_1"], COLUMN["deflection_2"]]]
        self._path += np.abs(np.diff(deflections, axis=0)).sum(axis=0)
        self.valid = self.valid or bool(self._path.min() > self.travel)
        forces = tuple(readings.forces[-1] + self.force_error)
        stiffness = stiffness_at_forces(forces, self.springs, self.config.joint)
        reason, status = ("", Status.VALID) if self.valid else ("transmission_1 CONVERGING", Status.CONVERGING)
        inputs = self.inputs
        inputs.joint = JointMeasurement(
            stiffness if self.valid else 1e9, self.valid, 0.9, self.valid, (0.5 * forces[0], 0.5 * forces[1]),
            self.valid, status, reason,
        )  # fmt: skip
        unusable = ExponentialSpring(0.0, 0.0, 50.0, 500.0)
        inputs.springs = self.springs if self.valid else (unusable, None)
        inputs.sensor_faults = self.sensor_fault, False
        inputs.angle, inputs.motors = float(readings.angle[-1]), tuple(readings.motors[-1])
        inputs.joint_ns = inputs.angle_ns = inputs.motors_ns = self.now
        inputs.springs_ns = self.now, self.now

    def truth(self):
        return self.true_stiffness(), *(self._row[COLUMN[name]] for name in ("angle", "force_1", "force_2"))

    def true_stiffness(self):
        sides = self.rig.config.transmission_1, self.rig.config.transmission_2
        exact = tuple(law(side) for side in sides)
        deflections = [self._row[COLUMN[f"deflection_{n}"]] for n in (1, 2)]
        forces = tuple(spring.force(x) for spring, x in zip(exact, deflections, strict=True))
        return stiffness_at_forces(forces, exact, self.config.joint)


def resting(stiffness=1.0, errors=(0.0, 0.0), **config):
    plant = Plant(errors, **config)
    plant.run(6.0, stiffness)
    assert plant.supervisor.mode is Mode.ACTIVE
    return plant


def modes(rows):
    """Modes in their order, without repetitions."""
    every = [row[0] for row in rows]
    return [mode for mode, before in zip(every, [None, *every[:-1]], strict=True) if mode is not before]


def numbers(rows):
    return np.array([row[1:] for row in rows])


def test_a_stiffness_that_is_invalid_at_rest_is_re_excited_until_it_is_valid_and_the_command_is_pursued():
    plant = resting(1.0, **RE_EXCITED)
    plant.invalidate(travel=1e-3)
    rows = plant.run(10.0, 1.0)
    assert modes(rows) == [Mode.FEED_FORWARD, Mode.EXCITING, Mode.ACTIVE]
    excited = sum(row[0] is Mode.EXCITING for row in rows) * PERIOD
    assert excited < 2.0
    assert plant.supervisor.waits_for == ""
    stiffness = numbers(plant.run(4.0, 2.0))[:, 0]
    assert np.abs(stiffness[100:] / 2.0 - 1.0).max() < 0.05


def test_control_goes_on_by_the_last_valid_law_while_its_predicted_error_is_tolerable():
    plant = resting(1.0, **RE_EXCITED)
    plant.invalidate()
    rows = plant.run(3.0, 2.0)
    assert modes(rows) == [Mode.FEED_FORWARD]
    assert np.abs(numbers(rows)[100:, 0] / 2.0 - 1.0).max() < 0.05
    supervisor = plant.supervisor
    assert supervisor.law_error == pytest.approx(math.hypot(0.01, 0.02 * math.sqrt(3.0)), abs=0.01)
    assert plant.run(4.0, 2.0)[-1][0] is Mode.EXCITING
    assert supervisor.law_error > plant.config.law_error_max


@pytest.mark.parametrize("error", [(-9.0, 0.0), (0.0, -12.0), (25.0, 0.0)])
@pytest.mark.parametrize(("tolerance", "mode"), [(0.05, Mode.FEED_FORWARD), (0.0, Mode.EXCITING)])
def test_forces_that_are_not_valid_change_no_motor_position(error, tolerance, mode):
    plant = resting(0.5, **RE_EXCITED, law_error_max=tolerance)
    plant.invalidate()
    healthy = numbers(plant.run(2.0, 0.5))
    plant = resting(0.5, **RE_EXCITED, law_error_max=tolerance)
    plant.invalidate()
    plant.force_error = np.array(error)
    rows = plant.run(2.0, 0.5)
    assert modes(rows) == [mode]
    assert np.abs(numbers(rows)[:, -2:] - healthy[:, -2:]).max() < 1e-3


def test_without_a_tolerance_the_re_excitation_begins_at_once():
    plant = resting(law_error_max=0.0, **RE_EXCITED)
    plant.invalidate(travel=1e-3)
    assert modes(plant.run(3.0, 1.0)) == [Mode.EXCITING, Mode.ACTIVE]


@pytest.mark.parametrize("stiffness", [0.35, 1.0, 7.0])
@pytest.mark.parametrize("errors", [(0.0, 0.0), (0.0, 0.3), (-0.2, 0.2)])
def test_the_re_excitation_respects_tension_speed_and_angle_also_with_a_wrong_law(stiffness, errors):
    plant = resting(stiffness, **RE_EXCITED)
    plant.springs = tuple(
        replace(spring, k2=spring.k2 * (1.0 + error)) for spring, error in zip(plant.springs, errors, strict=True)
    )
    plant.run(8.0, stiffness)
    plant.supervisor.reconfigure(replace(plant.config, law_error_max=0.0))
    plant.invalidate()
    angle = plant.run(PERIOD, stiffness)[0][2]
    rows = plant.run(8.0, stiffness)
    assert modes(rows) == [Mode.EXCITING]
    _, angles, first, second, *motors = numbers(rows).T
    assert np.abs(angles - angle).max() < plant.config.recovery_angle
    speeds = np.abs(np.diff(motors, axis=1)) / PERIOD
    assert speeds.max() <= plant.config.recovery_speed + 1e-9
    assert speeds.max() > 0.1
    assert max(first.max(), second.max()) < plant.config.force_max
    assert first.min() > plant.springs[0].slack_force
    assert second.min() > plant.springs[1].slack_force


def test_without_re_excitation_the_motors_hold_and_the_hold_has_its_end_and_its_duration():
    plant = resting()
    plant.invalidate()
    rows = plant.run(10.0, 1.0)
    assert modes(rows) == [Mode.FEED_FORWARD, Mode.HOLDING]
    held = np.array([row[-2:] for row in rows if row[0] is Mode.HOLDING])
    assert np.ptp(held, axis=0) == pytest.approx([0.0, 0.0])
    supervisor = plant.supervisor
    assert supervisor.reason == "joint stiffness invalid: transmission_1 CONVERGING"
    assert supervisor.waits_for.startswith("a valid stiffness: move the joint by hand")
    assert supervisor.duration(plant.now) == pytest.approx(len(held) * PERIOD, abs=0.02)
    plant.valid = True
    assert modes(plant.run(1.0, 1.0)) == [Mode.HOLDING, Mode.ACTIVE]


def test_a_sensor_fault_holds_at_once_and_after_its_end_control_goes_on():
    plant = resting(**RE_EXCITED)
    plant.invalidate()
    plant.sensor_fault = True
    assert modes(plant.run(1.0, 1.0)) == [Mode.HOLDING]
    assert plant.supervisor.waits_for == "the end of the sensor fault"
    plant.sensor_fault = False
    assert modes(plant.run(1.0, 1.0)) == [Mode.HOLDING, Mode.FEED_FORWARD]
    assert modes(plant.run(6.0, 1.0))[-1] is Mode.EXCITING


def test_the_re_excitation_ends_with_the_commands():
    plant = resting(law_error_max=0.0, **RE_EXCITED)
    plant.invalidate()
    plant.run(1.0, 1.0)
    assert modes(plant.run(1.0, 1.0, commands=False)) == [Mode.EXCITING, Mode.HOLDING]
    assert plant.supervisor.reason == "stiffness_command stopped"


def test_begin_and_end_of_the_re_excitation_are_smooth():
    plant = resting(law_error_max=0.0, **RE_EXCITED)
    before = plant.run(0.1, 1.0)
    plant.invalidate(travel=2e-3)
    rows = before + plant.run(5.0, 1.0)
    assert modes(rows) == [Mode.ACTIVE, Mode.EXCITING, Mode.ACTIVE]
    assert np.abs(np.diff(numbers(rows)[:, -2:], axis=0)).max() / PERIOD <= 1.5 * plant.config.recovery_speed


def test_a_push_does_not_end_the_re_excitation():
    plant = resting(law_error_max=0.0, **RE_EXCITED)
    plant.invalidate(travel=8e-3)
    plant.run(1.0, 1.0)
    rows = plant.run(12.0, 1.0, push=0.1)
    assert modes(rows) == [Mode.EXCITING, Mode.ACTIVE]


@pytest.mark.parametrize("equilibrium", [0.8, 1.6])
def test_a_step_of_the_equilibrium_keeps_the_speed_limit_of_the_motors_and_is_reached(equilibrium):
    plant = resting(1.0)
    rows = plant.run(6.0, 1.0, equilibrium=equilibrium)
    assert modes(rows) == [Mode.ACTIVE]
    assert plant.supervisor.target.equilibrium == equilibrium
    assert np.abs(np.diff(numbers(rows)[:, -2:], axis=0)).max() <= 1.2 * plant.config.motor_speed * PERIOD
    assert numbers(rows)[-100:, 1] == pytest.approx(equilibrium, abs=0.01)
