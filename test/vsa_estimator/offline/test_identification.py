# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Identification reproduces the coefficients of simulated data, with covariances that hold."""

from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from transmission_data import ANOTHER, MULTISINE, SLOW, TRANSMISSION_1, Rig, record
from vsa_estimator.offline.identification import NAMES, identify
from vsa_estimator.offline.recordings import Recording, RecordingError
from vsa_simulator.laws.config import ForceLaws
from vsa_simulator.laws.springs import SpringConfig
from vsa_simulator.rig.recording import Simulation, TransmissionVariant
from vsa_simulator.rig.single_transmission import MOTIONS

SEEDS = range(20)


def truth(rig: Rig) -> np.ndarray:
    return np.array([rig.k2, rig.k1, rig.force_offset, rig.coulomb_friction, rig.d1, rig.d2, rig.mass])


def recording(rig=TRANSMISSION_1, motion=MULTISINE, seconds=60.0, seed=1, rate=100) -> Recording:
    data = record(rig, motion, seconds, rate, seed)
    return Recording(Path("run.csv"), "transmission_1", data.stamp_ns, data.stamp_ns / 1e9, data.force, data.deflection)


@cache
def runs(rig: Rig, motion) -> tuple[np.ndarray, np.ndarray]:
    """Values and standard deviations, a row for each seed."""
    results = [identify([recording(rig, motion, seed=seed)]) for seed in SEEDS]
    return np.array([one.values for one in results]), np.array([np.sqrt(np.diag(one.covariance)) for one in results])


@pytest.mark.parametrize(("rig", "motion"), [(TRANSMISSION_1, MULTISINE), (ANOTHER, SLOW)])
def test_k2_is_within_a_percent_and_the_rest_within_their_intervals(rig, motion):
    values, stds = runs(rig, motion)
    assert np.abs(values[:, 0] / rig.k2 - 1.0).max() < 0.01
    held = np.abs(values - truth(rig)) < 1.96 * stds
    assert held.mean() >= 0.9
    # of 20 intervals of 95 %, fewer than 15 hold the truth once in 20,000 times
    assert dict(zip(NAMES, held.sum(axis=0), strict=True)) == {name: pytest.approx(20, abs=5) for name in NAMES}


def test_intervals_are_not_much_wider_than_the_errors():
    values, stds = runs(TRANSMISSION_1, MULTISINE)
    errors = (values - truth(TRANSMISSION_1)) / stds
    assert np.all(np.sqrt(np.mean(errors**2, axis=0)) > 0.4)


@pytest.mark.parametrize("seed", [0, 2])
def test_k2_of_a_narrow_stroke_is_within_its_interval(seed):
    """A stroke of 2 mm at 0.5 Hz hardly determines k2: the search for it stays in range."""
    variant = TransmissionVariant()
    data = Simulation(variant, MOTIONS["half_hz"], 40.0, 100).recording(seed)
    one = Recording(Path("run.csv"), "t", data.stamp_ns, data.stamp_ns / 1e9, data.force, data.deflection)
    found = identify([one])
    assert found.value("k2") == pytest.approx(267.2, abs=3.0 * found.std("k2"))
    assert 20.0 < found.value("k2") < 800.0
    assert found.value("d1") == pytest.approx(4000.0, abs=4.0 * found.std("d1"))


def test_two_recordings_reduce_the_standard_deviation():
    halves = [recording(seed=seed, seconds=30.0) for seed in range(1, 5)]
    one = [identify([half]).std("k2") for half in halves]
    two = [identify([first, second]).std("k2") for first, second in pairwise(halves)]
    assert np.mean(two) < 0.8 * np.mean(one)  # the square root of a half, with the scatter of few blocks


def test_held_force_samples_are_removed_and_counted():
    whole = recording(rate=500, seconds=30.0)
    force = np.repeat(whole.force[::4], 4)[: len(whole)]
    held = Recording(whole.source, "transmission_1", whole.stamp_ns, whole.stamp, force, whole.deflection)
    found = identify([held])
    assert found.repeated == len(whole) - len(whole.force[::4])
    assert found.value("k2") == pytest.approx(TRANSMISSION_1.k2, rel=0.02)


def test_the_exponent_of_a_short_uneven_curve_is_identified():
    """Law of (2) alone on 60 uneven points, as a stretched muscle is measured."""
    stamp = np.cumsum(np.linspace(0.1, 0.6, 60))
    deflection = 0.2 * stamp / stamp[-1]
    force = 0.4 + 0.35 * np.exp(14.0 * deflection) + 0.02 * np.random.default_rng(1).standard_normal(60)
    found = identify([Recording(Path("muscle.csv"), "t", np.round(stamp * 1e9).astype(int), stamp, force, deflection)])
    assert found.value("k2") == pytest.approx(14.0, abs=max(3.0 * found.std("k2"), 0.3))
    assert found.std("k2") < 1.5


def of_spring(kind, seed, motion="slow", seconds=40.0):
    """A recording of the simulated transmission with another spring; deflection and true stiffness, sorted."""
    variant = TransmissionVariant(laws=ForceLaws(spring=SpringConfig(kind)))
    truth = Simulation(variant, MOTIONS[motion], seconds, 100)
    data, order = truth.recording(seed), np.argsort(truth.deflection)
    one = Recording(Path("run.csv"), "t", data.stamp_ns, data.stamp_ns / 1e9, data.force, data.deflection)
    return one, truth.deflection[order], truth.stiffness[order]


@pytest.mark.parametrize("kind", ["linear", "quadratic", "sinh", "softening"])
def test_a_spring_of_any_form_is_within_its_band(kind):
    one, deflection, stiffness = of_spring(kind, seed=1)
    found = identify([one], any_law=True)
    assert not found.is_exponential
    assert found.deviation.is_significant
    along = np.linspace(found.deflection.min(), found.deflection.max(), 60)
    error = np.log(found.law.stiffness(along) / np.interp(along, deflection, stiffness))
    assert np.median(np.abs(error)) < 0.005
    assert np.mean(np.abs(error) < 1.96 * found.law.ln_std(along)) >= 0.8  # about ten independent intervals
    assert np.median(found.law.ln_std(along)) < 0.005
    assert found.value("d1") == pytest.approx(4000.0, abs=5.0 * found.std("d1"))
    assert found.residual.std() < 0.034  # noise of 0.017 N, and the friction near reversals


@pytest.mark.parametrize("motion", ["slow", "multisine"])
def test_the_exponential_spring_is_not_refuted(motion):
    one, *_ = of_spring("exponential", seed=2, motion=motion)
    found = identify([one], any_law=True)
    assert found.is_exponential
    assert found.deviation.probability > 0.01
    assert found.value("k2") == pytest.approx(267.2, rel=0.01)
    alone = identify([one])
    assert np.array_equal(alone.values, found.values)
    assert alone.deviation is None


def test_the_exponential_law_at_its_knots_is_that_of_its_coefficients():
    found = identify([recording()])
    k1, k2, offset = (found.value(name) for name in ("k1", "k2", "force_offset"))
    x = np.linspace(0.007, 0.014, 8)
    assert found.law.stiffness(x) == pytest.approx(k1 * k2 * np.exp(k2 * x), rel=1e-9)
    assert found.law.force(x) == pytest.approx(offset + k1 * np.exp(k2 * x), rel=1e-9)
    gradient = np.array([1.0 / k2 + 0.012, 1.0 / k1])  # of ln stiffness by k2 and k1
    assert found.law.ln_std(np.array([0.012]))[0] == pytest.approx(
        np.sqrt(gradient @ found.covariance[:2, :2] @ gradient), rel=1e-6
    )


def test_a_recording_at_rest_is_rejected():
    still = recording()
    with pytest.raises(RecordingError, match="moves"):
        identify([Recording(still.source, "t", still.stamp_ns, still.stamp, still.force, np.full(len(still), 0.01))])
