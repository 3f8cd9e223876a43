# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Rig, both estimators, joint fusion and stiffness controller, step by step without a clock: the output of each."""

from dataclasses import fields, is_dataclass, replace

import numpy as np
from vsa_bench.joint.case import estimator_config
from vsa_bench.joint.experiment import transmission_estimate
from vsa_estimator.estimator import Estimator
from vsa_joint.control.identified_spring import identified_spring
from vsa_joint.control.records import Inputs, JointMeasurement, Target
from vsa_joint.control.supervisor import Supervisor
from vsa_joint.impedance.fusion import JointFusion
from vsa_joint.settings import ControlConfig, JointConfig
from vsa_simulator.rig.config import RigConfig, TorqueConfig
from vsa_simulator.rig.rig import Rig

RATE_HZ, CONTROL_HZ = 500, 100
PLAN = ((14.0, None), (3.0, 1.0), (3.0, 2.0), (3.0, 6.0))  # seconds, commanded stiffness [N m/rad]


def run() -> dict[str, np.ndarray]:
    """Truth of every sample, joint estimates and motor commands of every control period."""
    quiet = RigConfig(
        rate_hz=RATE_HZ, seed=3, torque=TorqueConfig(amplitudes=(0.0,), frequencies=(1.0,), phases=(0.0,))
    )
    config = replace(quiet, transmission_2=replace(quiet.transmission_2, coulomb_friction=0.5))
    rig = Rig(config)
    sides = (config.transmission_1, config.transmission_2)
    estimators = [Estimator(estimator_config(c, config, i)) for i, c in enumerate(sides)]
    fusion, supervisor, inputs = JointFusion(JointConfig()), Supervisor(ControlConfig()), Inputs()
    truth, joints, commands, period = [], [], [], 0
    for seconds, stiffness in PLAN:
        for _ in range(round(seconds * CONTROL_HZ)):
            now = (period + 1) * 1_000_000_000 // CONTROL_HZ
            if stiffness is not None:
                supervisor.command(Target(0.0, stiffness), inputs, now)
            motors = supervisor.step(inputs, now)
            if motors is not None:
                rig.command(*motors)
            commands.append([np.nan, np.nan] if motors is None else list(motors))
            samples = rig.advance(RATE_HZ // CONTROL_HZ)
            truth.append(samples.truth)
            for i in range(len(samples.truth)):
                stamp = (samples.first + i + 1) * 1_000_000_000 // RATE_HZ
                for side, estimator in enumerate(estimators):
                    deflection = (int(samples.readings.counts[i, side]) - 1000) * 1e-5
                    estimate = estimator.add(stamp, float(samples.readings.forces[i, side]), deflection)
                    fusion.add(side, transmission_estimate(estimate), stamp)
            newest = fusion.newest
            joints.append(numbers(newest))
            inputs.joint = JointMeasurement(
                newest.stiffness, newest.stiffness_valid, newest.damping, newest.damping_valid, newest.tension,
                newest.force_valid, int(newest.status), newest.reason,
            )  # fmt: skip
            inputs.joint_ns = inputs.angle_ns = inputs.motors_ns = now
            inputs.angle, inputs.motors = float(samples.readings.angle[-1]), tuple(samples.readings.motors[-1])
            first, second = (identified_spring(estimator.state()) for estimator in estimators)
            inputs.springs, inputs.springs_ns = (first, second), (now, now)
            period += 1
    return {"rig": np.concatenate(truth), "joint": np.array(joints), "motor_commands": np.array(commands)}


def numbers(value) -> list[float]:
    """All numbers of a nested record, by field name."""
    if is_dataclass(value):
        return [x for name in sorted(f.name for f in fields(value)) for x in numbers(getattr(value, name))]
    if hasattr(value, "_asdict"):
        return [x for name in sorted(value._fields) for x in numbers(getattr(value, name))]
    if isinstance(value, np.ndarray):
        return value.ravel().astype(float).tolist()
    if isinstance(value, (tuple, list)):
        return [x for one in value for x in numbers(one)]
    return [] if isinstance(value, str) or value is None else [float(value)]
