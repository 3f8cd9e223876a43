# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The rig: sensors, motors with their watchdog, blocks, seeds."""

import ast
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import vsa_simulator.faults
import vsa_simulator.rig
from vsa_common.config.configuration import ConfigurationError
from vsa_simulator.rig.config import MotorConfig, RigConfig, SensorConfig, TorqueConfig
from vsa_simulator.rig.dynamics import TRUTH
from vsa_simulator.rig.motion import ProfileConfig
from vsa_simulator.rig.rig import Rig

PERFECT = SensorConfig(0.0, 0.0, 200.0, 0.0, 1e-9, 0, 0.0, 0.0)
STILL = RigConfig(
    profile=ProfileConfig(kind="hold"), torque=TorqueConfig(amplitudes=(0.0,), frequencies=(1.0,), phases=(0.0,))
)


def column(truth, name):
    return truth[:, TRUTH.index(name)]


def test_blocks_of_any_size_give_the_same_rig():
    whole = Rig(RigConfig(seed=3)).advance(300)
    split = Rig(RigConfig(seed=3))
    blocks = [split.advance(n) for n in (1, 99, 150, 50)]
    assert [block.first for block in blocks] == [0, 1, 100, 250]
    np.testing.assert_array_equal(np.concatenate([b.truth for b in blocks]), whole.truth)
    for name in whole.readings._fields:
        together = np.concatenate([getattr(b.readings, name) for b in blocks])
        np.testing.assert_array_equal(together, getattr(whole.readings, name))


GENERAL = (
    "ForceLaws(SpringConfig('tabulated', drift=5.0), DamperConfig('soft_knee'), FrictionConfig('stribeck'), "
    "ViscoelasticConfig(0.2), HysteresisConfig(0.5))"
)
SCRIPT = """
from vsa_simulator.laws.config import *
from vsa_simulator.rig.config import RigConfig, SensorErrorConfig
from vsa_simulator.rig.rig import Rig
laws = {laws}
errors = SensorErrorConfig({errors})
samples = Rig(RigConfig(**vars(laws), rate_hz=2000, sensor_errors=errors)).advance(12)
print(*map(repr, [*samples.truth[-1].tolist(), *samples.readings.forces[-1].tolist()]))
"""


@pytest.mark.parametrize(
    ("laws", "errors"),
    [("ForceLaws(friction=FrictionConfig('lugre'))", ""), (GENERAL, "0.002, 20.0, 0.1, crosstalk=0.02")],
    ids=("lugre", "general"),
)
def test_plain_python_equals_the_compiled_code(laws, errors):
    plain, compiled = (
        subprocess.run(
            [sys.executable, "-c", SCRIPT.format(laws=laws, errors=errors)],
            env=os.environ | {"VSA_NO_NUMBA": word},
            check=True,
            capture_output=True,
            text=True,
        ).stdout.split()
        for word in ("1", "")
    )
    np.testing.assert_allclose(np.array(plain, float), np.array(compiled, float), rtol=1e-9, atol=1e-15)


def test_another_seed_gives_other_noise_and_the_same_truth():
    one, other = Rig(RigConfig(seed=1)).advance(50), Rig(RigConfig(seed=2)).advance(50)
    np.testing.assert_array_equal(one.truth, other.truth)
    assert not np.array_equal(one.readings.forces, other.readings.forces)


def test_sensor_noise_has_the_configured_standard_deviation():
    config = RigConfig()
    samples = Rig(config).advance(20000)
    force = samples.readings.forces[:, 1] - column(samples.truth, "force_2")
    counts = samples.readings.counts[:, 0]
    deflection = counts * 1e-5 - column(samples.truth, "deflection_1")
    angle = samples.readings.angle - column(samples.truth, "angle")
    torque = samples.readings.torque - column(samples.truth, "external_torque")
    assert force.std() == pytest.approx(0.017, rel=0.03)
    assert deflection.std() == pytest.approx(np.hypot(1e-5, 1e-5 / np.sqrt(12)), rel=0.03)
    assert (angle.std(), torque.std()) == (pytest.approx(1e-4, rel=0.03), pytest.approx(1e-3, rel=0.03))
    for noise in (force, deflection, angle, torque):
        assert abs(noise.mean()) < 4.0 * noise.std() / np.sqrt(len(noise))
        assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 0.03  # white


def test_readings_without_noise_equal_the_truth():
    samples = Rig(replace(RigConfig(), sensors=PERFECT)).advance(500)
    np.testing.assert_array_equal(samples.readings.forces[:, 0], column(samples.truth, "force_1"))
    np.testing.assert_array_equal(samples.readings.angle, column(samples.truth, "angle"))
    np.testing.assert_array_equal(samples.readings.motors[:, 1], column(samples.truth, "motor_2"))


def test_the_encoder_counter_wraps_at_sixteen_bits():
    sensors = replace(PERFECT, deflection_resolution=1e-5, encoder_start=64400)
    samples = Rig(RigConfig(sensors=sensors)).advance(10000)
    counts = samples.readings.counts[:, 0]
    unwrapped = np.rint(column(samples.truth, "deflection_1") / 1e-5) + 64400
    assert unwrapped.min() < 65536 < unwrapped.max()
    np.testing.assert_array_equal(counts, unwrapped % 65536)


def test_the_force_sensor_saturates_at_its_range():
    sensors = replace(PERFECT, force_range=30.0)
    samples = Rig(RigConfig(sensors=sensors)).advance(10000)
    assert column(samples.truth, "force_1").max() > 50.0
    assert samples.readings.forces.max() == 30.0


def test_without_commands_both_rods_follow_the_profile_and_the_joint_is_at_rest():
    truth = Rig(RigConfig()).advance(20000).truth
    time, x = column(truth, "time"), column(truth, "deflection_1")
    late = time > 2.0
    tone = [(0.004, 0.05, 0.0), (0.00016, 0.7, 1.3), (0.00008, 1.7, 2.6)]
    profile = 0.0105 + sum(a * np.sin(2 * np.pi * f * time + p) for a, f, p in tone)
    assert np.abs(x - profile)[late].max() < 3e-4
    assert np.ptp(column(truth, "deflection_2")) > 6e-3
    assert np.abs(column(truth, "angle")).max() < 0.03


def test_a_command_overrides_the_profile_and_the_motors_reach_it():
    rig = Rig(STILL)
    rig.advance(10)
    start = rig.motors
    for _ in range(500):
        rig.command(start[0] + 0.1, start[1] - 0.05)
        rig.advance(2)
    assert rig.motors == pytest.approx((start[0] + 0.1, start[1] - 0.05), abs=1e-6)
    assert not rig.holding


def test_the_step_response_of_a_motor_is_critically_damped_at_its_bandwidth():
    rig = Rig(replace(STILL, motors=MotorConfig(speed_limit=1000.0, watchdog=10.0)))
    start = rig.motors[0]
    rig.command(start + 0.01, rig.motors[1])
    truth = rig.advance(200).truth
    wt = 2 * np.pi * 10.0 * column(truth, "time")
    np.testing.assert_allclose(
        column(truth, "motor_1") - start, 0.01 * (1.0 - (1.0 + wt) * np.exp(-wt)), rtol=1e-6, atol=1e-12
    )


def test_motors_keep_their_speed_and_position_limits():
    rig = Rig(replace(STILL, motors=MotorConfig(watchdog=10.0, upper_limit=2.5)))
    rig.command(80.0, 80.0)
    motor = column(rig.advance(3000).truth, "motor_1")
    speed = np.diff(motor) * 1000
    assert speed.max() <= 5.0 + 1e-9
    assert motor.max() <= 2.5 + 1e-9
    assert motor[-1] == pytest.approx(2.5, abs=1e-6)


def test_motors_hold_their_position_when_commands_stop_and_move_when_they_return():
    rig = Rig(STILL)
    for _ in range(50):
        rig.command(rig.motors[0] + 0.3, rig.motors[1])
        rig.advance(1)
    rig.advance(100)
    assert not rig.holding  # 0.1 s are not yet over
    rig.advance(1)
    rig.advance(1)
    assert rig.holding
    held = rig.motors[0]
    for _ in range(300):
        rig.advance(1)
    assert rig.motors[0] == pytest.approx(held, abs=0.2)  # it comes to rest, the profile does not resume
    resting = rig.motors[0]
    rig.advance(1000)
    assert rig.motors[0] == pytest.approx(resting, abs=1e-3)
    rig.command(resting + 0.1, rig.motors[1])
    rig.advance(50)
    assert not rig.holding
    assert rig.motors[0] > resting + 0.05


def test_the_watchdog_is_inactive_before_the_first_command():
    rig = Rig(RigConfig())
    rig.advance(2000)
    rig.advance(1)
    assert not rig.holding


def test_time_is_the_sample_over_the_rate():
    rig = Rig(RigConfig(rate_hz=300))
    truth = rig.advance(301).truth
    np.testing.assert_allclose(column(truth, "time"), np.arange(301) / 300, rtol=1e-12)
    assert (rig.sample, rig.time) == (301, pytest.approx(301 / 300))


@pytest.mark.parametrize(
    ("config", "text"),
    [
        (RigConfig(motors=MotorConfig(lower_limit=5.0, upper_limit=4.0)), "motors.lower_limit = 5.0 rad"),
        (RigConfig(torque=TorqueConfig(constant=-5.0)), "torque.constant = -5.0 N m: transmission 2 would go slack"),
        (RigConfig(torque=TorqueConfig(amplitudes=(0.1,))), "torque.amplitudes, frequencies and phases"),
    ],
)
def test_an_inconsistent_configuration_is_refused(config, text):
    with pytest.raises(ConfigurationError, match=text):
        Rig(config)


@pytest.mark.parametrize("folder", [vsa_simulator.rig, vsa_simulator.faults])
def test_rig_and_faults_import_neither_an_estimator_nor_ros_nor_a_bus(folder):
    forbidden = ("vsa_estimator", "vsa_joint", "vsa_bringup", "vsa_driver", "rclpy", "can", "cantools", "time", "open")
    for path in Path(folder.__path__[0]).glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom):
                names.append(node.module or "")
            for name in names:
                assert name.split(".")[0] not in forbidden, f"{path.name} imports {name}"
