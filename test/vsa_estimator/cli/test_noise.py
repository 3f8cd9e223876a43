# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The command `noise`: parameter file, figure and errors."""

import numpy as np
import pytest
from vsa_common.config.configuration import load
from vsa_common.io.tables import write_columns
from vsa_estimator.cli.noise import main
from vsa_estimator.settings import EstimatorConfig

STD = 0.017


def test_the_noise_figures_of_section_vi_are_reproduced(tmp_path, capsys):
    random = np.random.default_rng(5)
    stamp = np.arange(60_000) / 100.0
    force = 20.0 + 0.01 * stamp + STD * random.standard_normal(len(stamp))
    deflection = 0.010 + 1e-5 * random.standard_normal(len(stamp))
    write_columns(tmp_path / "ramp.csv", {"stamp": stamp, "force": force, "deflection": deflection})
    assert main([str(tmp_path / "ramp.csv"), "--out", str(tmp_path)]) == 0
    config = load(tmp_path / "noise.yaml", "estimator_1", EstimatorConfig)
    assert config.force_noise_std == pytest.approx(STD, rel=0.03)
    assert config.deflection_noise_std == pytest.approx(1e-5, rel=0.03)
    assert (tmp_path / "noise.png").stat().st_size > 10_000
    text = (tmp_path / "noise.yaml").read_text()
    rate = float(text.split("force_rate ")[1].split()[0])
    assert rate == pytest.approx(0.088, rel=0.05)
    assert "not white" not in capsys.readouterr().out


def test_the_noise_of_a_constant_encoder_is_the_least_that_the_estimator_accepts(tmp_path, capsys):
    stamp = np.arange(6000) / 100.0
    force = 20.0 + STD * np.random.default_rng(5).standard_normal(len(stamp))
    write_columns(tmp_path / "rest.csv", {"stamp": stamp, "force": force, "deflection": np.full(len(stamp), 0.01)})
    assert main([str(tmp_path / "rest.csv"), "--out", str(tmp_path)]) == 0
    config = load(tmp_path / "noise.yaml", "estimator_1", EstimatorConfig)
    assert config.deflection_noise_std == 1e-9
    assert config.force_noise_std == pytest.approx(STD, rel=0.05)
    assert "deflection did not change" in (tmp_path / "noise.yaml").read_text()
    assert "deflection did not change" in " ".join(capsys.readouterr().out.split())
    assert "force did not change" not in (tmp_path / "noise.yaml").read_text()


@pytest.mark.parametrize(
    ("stamps", "named"),
    [
        ([0.0, 0.01, 0.02], "samples"),
        ([*(1.7e9 + np.arange(300) * 0.01), 1.7e9 + 9.0], "gaps of 600 samples, the longest 2.990 s after the first"),
    ],
)
def test_a_recording_that_is_too_short_or_uneven_is_rejected(tmp_path, capsys, stamps, named):
    zeros = np.zeros(len(stamps))
    write_columns(tmp_path / "bad.csv", {"stamp": np.array(stamps), "force": zeros, "deflection": zeros})
    assert main([str(tmp_path / "bad.csv"), "--out", str(tmp_path)]) == 1
    assert named in capsys.readouterr().err
