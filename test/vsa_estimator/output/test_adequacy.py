# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Adequacy of the force law: limit of the usual residual with its hysteresis, and the place of a misfit."""

import numpy as np
import pytest
from vsa_bench.mismatch.cases import DEFAULT_LAW, MOTIONS
from vsa_bench.mismatch.run import start_parameters
from vsa_common.config.configuration import build
from vsa_common.types import Status
from vsa_estimator.estimator import Estimator
from vsa_estimator.output.adequacy import Adequacy
from vsa_estimator.settings import EstimatorConfig
from vsa_estimator.tuning.fault_detection import CONSISTENT_SHARE, MAX_SCALE
from vsa_simulator.rig.recording import Simulation, TransmissionVariant

K2, PEAK_SPEED = 250.0, 4e-3  # 1/m, m/s: bins of 1 mm and of 1 mm/s
WINDOW, WINDOWS = 50, 400  # rows of a decision window, and windows: 200 s
NONE = np.empty(0)
MISFIT = 2.0 * MAX_SCALE, 0.0, 1.0  # a window in motion: magnitude [N], stated std [N], share


def sweep(rng):
    """Deflection [m] and velocity [m/s] of sweeps through all bins, a window a row, and correlated residuals [N]."""
    time = 0.01 * np.arange(WINDOW * WINDOWS).reshape(WINDOWS, WINDOW)
    phase = 2.0 * np.pi * (0.07 * time + 0.03 * np.sin(0.2 * time))
    noise = np.repeat(rng.normal(0.0, 0.3, WINDOWS), WINDOW).reshape(WINDOWS, WINDOW)
    return 0.0095 + 4e-3 * np.sin(phase), 3e-3 * np.cos(2.3 * phase), noise


def described(deflection, velocity, residual):
    adequacy = Adequacy(K2, PEAK_SPEED)
    for x, v, r in zip(deflection, velocity, residual, strict=True):
        adequacy.add(MISFIT, r, x, v)
    return adequacy.describe()


def decided(adequacy, magnitude, std=0.0, in_motion=1.0, count=300):
    """Whether the law is inadequate after `count` windows."""
    for _ in range(count):
        adequacy.add((magnitude, std, in_motion), NONE, NONE, NONE)
    return adequacy.is_inadequate


def test_the_unexplained_force_decides_with_a_hysteresis():
    adequacy = Adequacy(K2, PEAK_SPEED)
    shares = (0.9, 1.1, 1.1 * CONSISTENT_SHARE, 0.9 * CONSISTENT_SHARE, 0.9)
    assert [decided(adequacy, share * MAX_SCALE) for share in shares] == [False, True, True, False, False]
    assert adequacy.describe() == ""


def test_a_residual_within_the_stated_error_is_no_misfit():
    assert not decided(Adequacy(K2, PEAK_SPEED), 2.0 * MAX_SCALE, std=1.1 * MAX_SCALE)
    assert decided(Adequacy(K2, PEAK_SPEED), 2.0 * MAX_SCALE, std=0.4 * MAX_SCALE)


def test_a_rest_decides_nothing():
    adequacy = Adequacy(K2, PEAK_SPEED)
    assert not decided(adequacy, 2.0 * MAX_SCALE, in_motion=0.0)
    assert decided(adequacy, 2.0 * MAX_SCALE)
    assert decided(adequacy, 0.0, in_motion=0.0)


def test_residuals_of_noise_have_no_place():
    """The false places of 40 draws: at most 1 at the significance of 4 standard errors in 64 bins (expected 0.2)."""
    texts = [described(*sweep(np.random.default_rng(seed))) for seed in range(40)]
    assert sum("no particular deflection or velocity" not in text for text in texts) <= 1
    assert texts[0].startswith("model inadequate: 0.8 N of the force unexplained")


def test_a_misfit_in_deflection_is_placed_within_its_bin():
    x, v, noise = sweep(np.random.default_rng(1))
    text = described(x, v, noise + 0.8 * ((x > 0.0120) & (x < 0.0132)))
    low, high = (float(word) for word in text.split("deflections of ")[1].removesuffix(" mm").split(" to "))
    assert 11.0 <= low <= 13.0
    assert high - low == pytest.approx(1.0, abs=0.11)


def test_a_misfit_in_velocity_is_placed_with_its_sign():
    x, v, noise = sweep(np.random.default_rng(2))
    assert "velocities of -3 to -2 mm/s" in described(x, v, noise + 0.8 * (v < -2e-3))


def test_a_restart_drops_all_that_was_measured():
    adequacy = Adequacy(K2, PEAK_SPEED)
    adequacy.add(MISFIT, np.ones(9), np.full(9, 0.01), np.zeros(9))
    assert decided(adequacy, 2.0 * MAX_SCALE)
    adequacy.restart()
    assert not adequacy.is_inadequate
    assert decided(adequacy, 2.0 * MAX_SCALE)
    assert adequacy.describe().endswith("at no particular deflection or velocity")


@pytest.fixture(scope="module")
def simulation():
    return Simulation(TransmissionVariant(), MOTIONS["mix"], 60.0, 100)


def estimated(simulation, asymmetry):
    """Rows and state for a damper whose force in extension is greater by `asymmetry`, and in compression less."""
    recording = simulation.recording(1)
    speed, peak = np.clip(simulation.velocity, -3.3e-3, 3.3e-3), 3.3e-3  # [m/s]
    force = asymmetry * 5e3 * np.abs(speed - speed**3 / (3.0 * peak**2))  # even in velocity: of no law of the bank
    parameters = {**start_parameters(simulation, 1), "elastic_law": DEFAULT_LAW}
    estimator = Estimator(build(EstimatorConfig, parameters))
    rows = estimator.add_many(recording.stamp_ns, recording.force + force, recording.deflection)
    return rows[simulation.time > 20.0], estimator.state()


def test_an_asymmetric_damper_is_an_inadequate_model_at_velocities(simulation):
    rows, state = estimated(simulation, 0.3)
    assert np.mean(rows["status"] == Status.MODEL_INADEQUATE) > 0.9
    assert state.status is Status.MODEL_INADEQUATE
    assert "model inadequate: " in state.reason
    assert "most at velocities of " in state.reason
    stiffness, valid = simulation.stiffness[simulation.time > 20.0], rows["stiffness_valid"] > 0
    error = np.abs(np.log(rows["stiffness"] / stiffness)) / (np.sqrt(rows["stiffness_variance"]) / rows["stiffness"])
    assert np.mean(error[valid] < 1.96) > 0.9  # what is published contains the misfit


def test_the_paper_s_law_is_adequate(simulation):
    rows, state = estimated(simulation, 0.0)
    assert not (rows["status"] == Status.MODEL_INADEQUATE).any()
    assert state.reason == ""
