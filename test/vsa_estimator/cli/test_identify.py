# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The command `identify`: parameter file, figure and errors."""

import re

import numpy as np
import pytest
import yaml
from transmission_data import MULTISINE, TRANSMISSION_1, column, record, run
from vsa_common.config.configuration import load
from vsa_common.io.tables import write_columns
from vsa_estimator.cli.identify import main
from vsa_estimator.estimator import Estimator
from vsa_estimator.initialization.previous_run import coefficients_of
from vsa_estimator.settings import EstimatorConfig
from vsa_simulator.laws.config import ForceLaws
from vsa_simulator.laws.springs import SpringConfig
from vsa_simulator.rig.recording import Simulation, TransmissionVariant
from vsa_simulator.rig.single_transmission import MOTIONS


def test_the_estimator_loads_its_start_values_from_the_parameter_file(tmp_path, capsys):
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


@pytest.fixture(scope="module")
def quadratic(tmp_path_factory):
    """A recording of a quadratic spring, and one to validate with."""
    folder = tmp_path_factory.mktemp("quadratic")
    variant = TransmissionVariant(laws=ForceLaws(spring=SpringConfig("quadratic")))
    truth = Simulation(variant, MOTIONS["slow"], 40.0, 100)
    data = truth.recording(1)
    columns = {"stamp": data.stamp_ns / 1e9, "force": data.force, "deflection": data.deflection}
    write_columns(folder / "run.csv", columns)
    return folder / "run.csv", truth


def test_another_law_is_reported_and_gives_orders_of_magnitude_to_the_bank(quadratic, tmp_path, capsys):
    path, truth = quadratic
    assert main([str(path), "--out", str(tmp_path / "mine.yaml")]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "the exponential law is refuted: the stiffness deviates from it at" in printed
    assert "off the exponential [%]" in printed
    config = load(tmp_path / "mine.yaml", "estimator_1", EstimatorConfig)
    initial = config.initial
    assert config.elastic_law == "automatic"
    assert not initial.posterior  # the coefficients of the exponential law
    stroke = np.ptp(truth.deflection)
    middle = np.argmin(np.abs(truth.deflection - np.median(truth.deflection)))
    assert 1.0 / stroke <= initial.k2 <= 4.0 / stroke
    assert initial.k2_std / initial.k2 == pytest.approx(90.0 / 267.2, rel=1e-3)  # as of the defaults
    force = truth.force[middle] - truth.damping[middle] * truth.velocity[middle]
    assert initial.k2 * (force - initial.force_offset) == pytest.approx(truth.stiffness[middle], rel=0.25)
    assert initial.d1 == pytest.approx(4000.0, rel=0.05)
    text = (tmp_path / "mine.yaml").read_text()
    assert len(re.findall(r"# /\*\*/estimator_1: stiffness at [\d.]+ m = [\d.e+]+ \+- [\d.e+]+ N/m", text)) == 17
    assert (tmp_path / "mine.png").stat().st_size > 10_000


def test_the_exponential_law_can_be_chosen_for_any_recording(quadratic, tmp_path, capsys):
    path, _ = quadratic
    out = tmp_path / "mine.yaml"
    assert main([str(path), "--out", str(out), "--elastic-law", "exponential"]) == 0
    assert "elastic_law: exponential" in out.read_text()
    assert load(out, "estimator_1", EstimatorConfig).elastic_law == "exponential"
    assert "refuted" not in capsys.readouterr().out


def test_a_file_that_is_too_short_is_named_in_the_error(tmp_path, capsys):
    (tmp_path / "short.csv").write_text("stamp,force,deflection\n0.0,1.0,0.01\n")
    assert main([str(tmp_path / "short.csv"), "--out", str(tmp_path / "mine.yaml")]) == 1
    assert "short.csv" in capsys.readouterr().err


@pytest.mark.parametrize("count", [12, 13, 20, 29, 40, 119])
def test_too_few_rows_of_a_fast_recording_are_a_one_line_error(tmp_path, capsys, count):
    time = np.arange(count) / 1000.0
    deflection = 0.010 + 0.002 * np.sin(30.0 * time)
    columns = {"stamp": time, "force": 16.0 + 0.776 * np.exp(267.2 * deflection), "deflection": deflection}
    write_columns(tmp_path / "short.csv", columns)
    assert main([str(tmp_path / "short.csv"), "--out", str(tmp_path / "mine.yaml")]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert f"short.csv: expected at least 120 usable samples, found {count}" in error  # 12 of 100 Hz


def test_the_file_has_the_covariance_about_the_middle_of_the_data_and_starts_an_estimator(tmp_path):
    data, rest = record(TRANSMISSION_1, MULTISINE, 40.0), record(TRANSMISSION_1, MULTISINE, 10.0, seed=2)
    columns = {"stamp": data.stamp_ns / 1e9, "force": data.force, "deflection": data.deflection}
    write_columns(tmp_path / "run.csv", columns)
    assert main([str(tmp_path / "run.csv"), "--out", str(tmp_path / "mine.yaml")]) == 0
    config = load(tmp_path / "mine.yaml", "estimator_1", EstimatorConfig)
    mean, covariance, reference = coefficients_of(config.initial)
    truth = np.log(TRANSMISSION_1.k2 * TRANSMISSION_1.k1) + TRANSMISSION_1.k2 * reference
    std = np.sqrt(np.diag(covariance))
    assert reference == pytest.approx(np.median(data.deflection), abs=1e-3)
    assert abs(mean[0] - truth) < 4.0 * std[0] < 0.02
    assert abs(mean[1] - TRANSMISSION_1.k2) < 4.0 * std[1]
    assert std[1] == pytest.approx(config.initial.k2_std, rel=1e-5)
    estimates = run(Estimator(config), rest)
    valid = column(estimates, "stiffness_valid") > 0
    assert np.flatnonzero(valid)[0] < 100
    assert np.abs(np.log(column(estimates, "stiffness") / rest.stiffness))[valid].max() < 0.01
