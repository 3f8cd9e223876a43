"""Allan deviation of noises whose law is known."""

import numpy as np
import pytest
from vsa_common.config.configuration import load
from vsa_common.io.tables import write_columns
from vsa_estimator.cli.noise import main
from vsa_estimator.force_rate.rate_filter import RATE_FILTER, RateFilter, filtered_rate
from vsa_estimator.offline.allan import allan
from vsa_estimator.settings import EstimatorConfig

STD = 0.017


def white(seed: int, count: int = 20_000) -> np.ndarray:
    return STD * np.random.default_rng(seed).standard_normal(count)


@pytest.mark.parametrize("seed", range(20))
def test_white_noise_is_measured_within_three_percent_and_called_white(seed):
    found = allan(white(seed), 100.0)
    assert found.white
    assert found.std == pytest.approx(STD, rel=0.03)
    assert found.density == pytest.approx(STD / 10.0, rel=0.03)


@pytest.mark.parametrize("seed", range(20))
def test_drift_is_not_white_and_does_not_count_as_noise(seed):
    drift = np.cumsum(0.03 * STD * np.random.default_rng(100 + seed).standard_normal(20_000))
    found = allan(white(seed) + drift, 100.0)
    assert not found.white
    assert found.std == pytest.approx(STD, rel=0.03)


def test_smoothed_noise_is_not_white():
    assert not allan(np.convolve(white(1), np.ones(5) / 5.0, "valid"), 100.0).white


def test_a_constant_has_no_noise_to_be_white():
    assert not allan(np.full(1000, 3.0), 100.0).white


def test_the_figures_of_section_vi_come_back(tmp_path, capsys):
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


@pytest.mark.parametrize(
    ("stamps", "named"), [([0.0, 0.01, 0.02], "samples"), ([*np.arange(300) * 0.01, 9.0], "line 302")]
)
def test_a_recording_that_cannot_serve_is_refused(tmp_path, capsys, stamps, named):
    zeros = np.zeros(len(stamps))
    write_columns(tmp_path / "bad.csv", {"stamp": np.array(stamps), "force": zeros, "deflection": zeros})
    assert main([str(tmp_path / "bad.csv"), "--out", str(tmp_path)]) == 1
    assert named in capsys.readouterr().err


def test_the_rate_filter_lags_a_ramp_by_its_time_constant():
    """Response of a first-order lag to a ramp of 2 N/s: 2 (1 - exp(-t / tau))."""
    time = np.arange(200) * 0.01
    expected = 2.0 * (1.0 - np.exp(-time / RATE_FILTER))
    np.testing.assert_allclose(filtered_rate(2.0 * time, 0.01), expected, atol=1e-12)


def test_the_rate_filter_is_the_same_sample_by_sample():
    force, rate = white(3, 500), RateFilter()
    np.testing.assert_allclose([rate.add(f, 0.01) for f in force], filtered_rate(force, 0.01), rtol=1e-9, atol=1e-12)
