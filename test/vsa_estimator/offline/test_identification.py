"""Identification finds the coefficients that made the data, and knows how well."""

from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import yaml
from transmission_data import ANOTHER, MULTISINE, SLOW, TRANSMISSION_1, Rig, record
from vsa_common.config.configuration import load
from vsa_common.io.tables import write_columns
from vsa_estimator.cli.identify import main
from vsa_estimator.offline.identification import NAMES, identify
from vsa_estimator.offline.recordings import Recording, RecordingError
from vsa_estimator.settings import EstimatorConfig

SEEDS = range(20)


def truth(rig: Rig) -> np.ndarray:
    return np.array([rig.k2, rig.k1, rig.force_offset, rig.coulomb_friction, rig.d1, rig.d2, rig.mass])


def recording(rig=TRANSMISSION_1, motion=MULTISINE, seconds=60.0, seed=1, rate=100) -> Recording:
    data = record(rig, motion, seconds, rate, seed)
    return Recording(Path("run.csv"), "transmission_1", data.stamp_ns, data.stamp_ns / 1e9, data.force, data.deflection)


@cache
def runs(rig: Rig, motion) -> tuple[np.ndarray, np.ndarray]:
    """Values and standard deviations of one identification a seed."""
    found = [identify([recording(rig, motion, seed=seed)]) for seed in SEEDS]
    return np.array([one.values for one in found]), np.array([np.sqrt(np.diag(one.covariance)) for one in found])


@pytest.mark.parametrize(("rig", "motion"), [(TRANSMISSION_1, MULTISINE), (ANOTHER, SLOW)])
def test_k2_within_a_percent_and_the_rest_within_their_intervals(rig, motion):
    values, stds = runs(rig, motion)
    assert np.abs(values[:, 0] / rig.k2 - 1.0).max() < 0.01
    held = np.abs(values - truth(rig)) < 1.96 * stds
    assert held.mean() >= 0.9
    # of 20 intervals of 95 %, fewer than 15 hold the truth once in 20,000 times
    assert dict(zip(NAMES, held.sum(axis=0), strict=True)) == {name: pytest.approx(20, abs=5) for name in NAMES}


def test_intervals_are_no_wider_than_the_errors_ask_for():
    values, stds = runs(TRANSMISSION_1, MULTISINE)
    errors = (values - truth(TRANSMISSION_1)) / stds
    assert np.all(np.sqrt(np.mean(errors**2, axis=0)) > 0.4)


def test_two_recordings_know_more_than_one():
    halves = [recording(seed=seed, seconds=30.0) for seed in range(1, 5)]
    one = [identify([half]).std("k2") for half in halves]
    two = [identify([first, second]).std("k2") for first, second in pairwise(halves)]
    assert np.mean(two) < 0.8 * np.mean(one)  # the square root of a half, but for the scatter of few blocks


def test_held_force_samples_are_left_out_and_counted():
    whole = recording(rate=500, seconds=30.0)
    force = np.repeat(whole.force[::4], 4)[: len(whole)]
    held = Recording(whole.source, "transmission_1", whole.stamp_ns, whole.stamp, force, whole.deflection)
    found = identify([held])
    assert found.repeated == len(whole) - len(whole.force[::4])
    assert found.value("k2") == pytest.approx(TRANSMISSION_1.k2, rel=0.02)


def test_a_short_uneven_curve_gives_its_exponent():
    """Law of (2) alone on 60 uneven points, as a stretched muscle is measured."""
    stamp = np.cumsum(np.linspace(0.1, 0.6, 60))
    deflection = 0.2 * stamp / stamp[-1]
    force = 0.4 + 0.35 * np.exp(14.0 * deflection) + 0.02 * np.random.default_rng(1).standard_normal(60)
    found = identify([Recording(Path("muscle.csv"), "t", np.round(stamp * 1e9).astype(int), stamp, force, deflection)])
    assert found.value("k2") == pytest.approx(14.0, abs=max(3.0 * found.std("k2"), 0.3))
    assert found.std("k2") < 1.5


def test_a_rod_at_rest_is_refused():
    still = recording()
    with pytest.raises(RecordingError, match="moves"):
        identify([Recording(still.source, "t", still.stamp_ns, still.stamp, still.force, np.full(len(still), 0.01))])


def test_the_estimator_starts_from_the_file(tmp_path, capsys):
    data = record(TRANSMISSION_1, MULTISINE, 30.0)
    columns = {"stamp": data.stamp_ns / 1e9, "force": data.force, "deflection": data.deflection}
    write_columns(tmp_path / "run.csv", columns)
    assert main([str(tmp_path / "run.csv"), "--out", str(tmp_path / "mine.yaml")]) == 0
    initial = load(tmp_path / "mine.yaml", "estimator_1", EstimatorConfig).initial
    assert initial.k2 == pytest.approx(TRANSMISSION_1.k2, rel=0.01)
    assert 0.0 < initial.k2_std < 3.0
    assert initial.force_offset == pytest.approx(TRANSMISSION_1.force_offset, abs=0.5)
    assert set(yaml.safe_load((tmp_path / "mine.yaml").read_text())) == {"/**/estimator_1"}
    assert (tmp_path / "mine.png").stat().st_size > 10_000
    assert "variance" in capsys.readouterr().out


def test_a_file_too_short_is_named(tmp_path, capsys):
    (tmp_path / "short.csv").write_text("stamp,force,deflection\n0.0,1.0,0.01\n")
    assert main([str(tmp_path / "short.csv"), "--out", str(tmp_path / "mine.yaml")]) == 1
    assert "short.csv" in capsys.readouterr().err
