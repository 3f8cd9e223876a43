# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Schedule and evaluation of the stiffness steps, and a short closed-loop run of the pure cores."""

import argparse
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from vsa_bench.joint.case import estimator_config
from vsa_bench.joint.experiment import transmission_estimate
from vsa_estimator.estimator import Estimator
from vsa_joint.control.identified_spring import identified_spring
from vsa_joint.control.mode import Mode
from vsa_joint.control.records import Inputs, JointMeasurement, Target
from vsa_joint.control.supervisor import Supervisor
from vsa_joint.impedance.fusion import JointFusion
from vsa_joint.settings import ControlConfig, JointConfig
from vsa_simulator.rig.config import RigConfig, TorqueConfig
from vsa_simulator.rig.dynamics import TRUTH
from vsa_simulator.rig.rig import Rig
from vsa_tools.demo.command import exit_code
from vsa_tools.scenarios import stiffness_acceptance as acceptance
from vsa_tools.scenarios import stiffness_plan as plan
from vsa_tools.scenarios.stiffness_steps import Scenario

STORED_RUN = Path(__file__).parents[2] / "golden" / "stored_run.tar.xz"
RATE_HZ, CONTROL_HZ = 500, 100


class Chain:
    """Rig, both estimators, joint and controller in closed loop; the initial coefficients are wrong."""

    def __init__(self, **config):
        rig = RigConfig(
            rate_hz=RATE_HZ, seed=3, torque=TorqueConfig(amplitudes=(0.0,), frequencies=(1.0,), phases=(0.0,))
        )
        self.config = replace(rig, transmission_2=replace(rig.transmission_2, coulomb_friction=0.5))
        self.rig = Rig(self.config)
        sides = (self.config.transmission_1, self.config.transmission_2)
        self.estimators = [Estimator(estimator_config(c, self.config, i)) for i, c in enumerate(sides)]
        self.fusion, self.supervisor = JointFusion(JointConfig()), Supervisor(ControlConfig(**config))
        self.inputs, self.period = Inputs(), 0

    def run(self, seconds, stiffness=None):
        """Truth of each sample by name, and the controller's mode at each period."""
        rows, modes = [], []
        for _ in range(round(seconds * CONTROL_HZ)):
            now = (self.period + 1) * 1_000_000_000 // CONTROL_HZ
            if stiffness is not None:
                self.supervisor.command(Target(0.0, stiffness), self.inputs, now)
            motors = self.supervisor.step(self.inputs, now)
            if motors is not None:
                self.rig.command(*motors)
            modes.append(self.supervisor.mode)
            samples = self.rig.advance(RATE_HZ // CONTROL_HZ)
            rows.append(samples.truth)
            self._estimate(samples)
            self._read(samples, now)
            self.period += 1
        truth = np.concatenate(rows)
        return {name: truth[:, i] for i, name in enumerate(TRUTH)}, modes

    def _estimate(self, samples):
        for i in range(len(samples.truth)):
            stamp = (samples.first + i + 1) * 1_000_000_000 // RATE_HZ
            for side, estimator in enumerate(self.estimators):
                deflection = (int(samples.readings.counts[i, side]) - 1000) * 1e-5
                estimate = estimator.add(stamp, float(samples.readings.forces[i, side]), deflection)
                self.fusion.add(side, transmission_estimate(estimate), stamp)

    def _read(self, samples, now):
        newest, inputs = self.fusion.newest, self.inputs
        inputs.joint = JointMeasurement(
            newest.stiffness, newest.stiffness_valid, newest.damping, newest.damping_valid, newest.tension,
            newest.force_valid, int(newest.status), newest.reason,
        )  # fmt: skip
        inputs.joint_ns = inputs.angle_ns = inputs.motors_ns = now
        inputs.angle, inputs.motors = float(samples.readings.angle[-1]), tuple(samples.readings.motors[-1])
        first, second = (identified_spring(estimator.state()) for estimator in self.estimators)
        inputs.springs, inputs.springs_ns = (first, second), (now, now)


def test_with_live_estimates_stiffness_doubles_within_a_second_at_a_constant_angle():
    chain = Chain()
    chain.run(plan.INITIALIZATION_S)
    chain.run(4.0, 1.0)
    joint = JointConfig().joint
    for stiffness in (2.0, 4.0, 2.0):
        truth, modes = chain.run(4.0, stiffness)
        true = plan.true_stiffness(truth, joint)
        outside = np.nonzero(np.abs(true / stiffness - 1.0) > 0.05)[0]
        assert outside[-1] / RATE_HZ < 1.0
        assert set(modes) == {Mode.ACTIVE}
        assert np.abs(truth["angle"]).max() < 0.030
        assert np.abs(truth["angle"][-500:]).max() < 0.010


def test_estimators_that_restart_at_rest_are_re_excited_and_the_next_step_is_reached():
    chain = Chain(recovery_amplitude=5e-4)
    chain.run(plan.INITIALIZATION_S)
    chain.run(5.0, 4.0)
    for estimator in chain.estimators:
        estimator.reset()
    truth, modes = chain.run(10.0, 4.0)
    excited = modes.count(Mode.EXCITING) / CONTROL_HZ
    assert Mode.HOLDING not in modes
    assert modes[-1] is Mode.ACTIVE
    assert 0.0 < excited < 3.0
    assert np.abs(truth["angle"] - truth["angle"][0]).max() < ControlConfig().recovery_angle
    truth, modes = chain.run(4.0, 2.0)
    true = plan.true_stiffness(truth, JointConfig().joint)
    assert np.abs(true[RATE_HZ:] / 2.0 - 1.0).max() < 0.05
    assert Mode.HOLDING not in modes


def synthetic(tau=0.2):
    """Truth of a joint that follows each command with a first-order lag, and the torque of the pushes."""
    time = np.arange(0.0, plan.duration(), 0.002)
    commands = [*plan.step_commands(), *plan.push_commands()]
    log = np.zeros_like(time)
    for before, command in zip([None, *commands[:-1]], commands, strict=True):
        start = np.log(before.stiffness) if before else 0.0
        late = time >= command.time
        target = np.log(command.stiffness)
        log[late] = target + (start - target) * np.exp(-(time[late] - command.time) / tau)
    torque = np.zeros_like(time)
    for push in plan.pushes():
        torque[time >= push.time] = push.torque
    return time, np.exp(log), torque


def test_settling_is_measured_from_the_command():
    time, stiffness, _ = synthetic(tau=0.2)
    begins = [command.time for command in plan.step_commands()]
    steps = plan.evaluate_steps(time, stiffness, 0.004 * np.ones_like(time), begins)
    doubled = steps[0]
    expected = 0.2 * np.log(np.log(2.0) / -np.log(0.95))
    assert (doubled.start, doubled.to) == (1.0, 2.0)
    assert doubled.settle_5pct_s == pytest.approx(expected, abs=0.01)
    assert doubled.equilibrium_steady_mrad == pytest.approx(4.0)
    assert doubled.steady_error == pytest.approx(0.0, abs=1e-3)
    assert list(doubled.row()) == [
        "from", "to", "settle_5pct_s", "equilibrium_steady_mrad", "equilibrium_transient_mrad", "steady_error",
    ]  # fmt: skip


def actual_begins():
    return [command.time for command in acceptance.commands()]


def test_every_command_of_a_joint_that_follows_is_reached_and_nothing_fails():
    time, stiffness, _ = synthetic(tau=0.2)
    reached = acceptance.reached(time, stiffness, actual_begins())
    assert [one["stiffness"] for one in reached] == [*plan.STEPS, *plan.PUSH_STIFFNESSES]
    expected = 0.2 * np.log(np.log(2.0) / -np.log(0.95))
    assert reached[1]["reached_s"] == pytest.approx(expected, abs=0.01)
    assert acceptance.failures({"reached": reached, "holds": []}) == []


def test_a_step_that_is_not_reached_fails_with_its_time_and_error():
    time, stiffness, _ = synthetic(tau=0.2)
    locked = plan.INITIALIZATION_S + 2 * plan.STEP_S + 4.0  # at 4 N m/rad
    stiffness = np.where(time > locked, 4.0, stiffness)
    failures = acceptance.failures({"reached": acceptance.reached(time, stiffness, actual_begins()), "holds": []})
    assert failures[0] == "2 N m/rad, commanded at 39.0 s, not reached: +100.0 % at its end"
    assert len(failures) == 7  # all but those of 4 N m/rad


def test_a_passage_through_the_band_is_not_reached_and_an_excursion_after_it_is():
    time, stiffness, _ = synthetic(tau=0.2)
    begin = plan.step_commands()[1].time
    late = (time > begin + 3.0) & (time < begin + 5.0)
    assert acceptance.reached(time, np.where(late, 2.5, stiffness), actual_begins())[1]["reached_s"] < 1.0
    passing = np.where(time > begin + 0.8, 2.5, stiffness)
    assert acceptance.reached(time, passing, actual_begins())[1]["reached_s"] is None


def test_holds_of_one_cause_are_one_and_a_long_one_fails_with_its_reason():
    modes = [
        acceptance.ControlMode(24.0, "active", ""),
        acceptance.ControlMode(30.0, "holding", "joint stiffness invalid"),
        acceptance.ControlMode(30.8, "holding", "joint_impedance silent"),
        acceptance.ControlMode(31.2, "active", ""),
        acceptance.ControlMode(40.0, "exciting", "joint stiffness invalid"),
        acceptance.ControlMode(42.0, "active", ""),
        acceptance.ControlMode(50.0, "holding", "stiffness_command stopped"),
    ]
    holds = acceptance.holds(modes, 50.5)
    assert [(one["mode"], one["duration_s"]) for one in holds] == [
        ("holding", 1.2), ("exciting", 2.0), ("holding", 0.5),
    ]  # fmt: skip
    assert acceptance.failures({"reached": [], "holds": holds}) == [
        "motors held for 1.2 s from 30.0 s on: joint stiffness invalid"
    ]


def test_a_stored_run_is_evaluated_with_its_exit_code(tmp_path, capsys):
    shutil.unpack_archive(STORED_RUN, tmp_path)
    scenario = Scenario(argparse.Namespace(duration=0.0, out=tmp_path / "run"))
    figures = scenario.evaluate(tmp_path / "run")
    assert len(figures["reached"]) == len(acceptance.commands())
    failures = scenario.failures(figures)
    assert failures
    assert exit_code(failures) == 1
    assert f"demo: {failures[0]}" in capsys.readouterr().err
    assert exit_code([]) == 0


def test_rendered_stiffness_is_torque_over_angle():
    time, stiffness, torque = synthetic()
    for one in plan.evaluate_pushes(time, torque / stiffness / 1.07, torque):
        assert one["rendered"] == pytest.approx(1.07 * one["commanded"], rel=1e-3)


def test_the_plan_commands_an_unreachable_stiffness_once():
    commands = [plan.commanded(t) for t in np.arange(0.0, plan.duration(), 0.1)]
    assert commands[0] is None
    assert plan.UNREACHABLE in commands
    assert plan.commanded(plan.refusal_time() + plan.REFUSAL_S + 0.1) == plan.PUSH_STIFFNESSES[0]


def test_pushes_have_both_signs_and_end_at_zero():
    torques = [push.torque for push in plan.pushes()]
    assert max(torques) == pytest.approx(0.4)
    assert min(torques) == pytest.approx(-0.4)
    assert torques[-1] == pytest.approx(0.0, abs=1e-12)
    times = [push.time for push in plan.pushes()]
    assert times == sorted(times)
