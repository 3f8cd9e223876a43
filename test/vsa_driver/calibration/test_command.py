# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
import yaml
from vsa_common.config.configuration import load
from vsa_common.io.bags import Recording
from vsa_common.io.tables import write_columns
from vsa_driver.acquisition.calibration import Calibration
from vsa_driver.calibration.command import main
from vsa_driver.calibration.fit import GaugeError, fit, fit_logs
from vsa_driver.settings import DriverSettings

SCALE, OFFSET = 1.0325, -0.42  # true = SCALE * read + OFFSET


def load_force(t):
    """True force [N]: a slow sine over the range with a fast component."""
    return 60.0 + 55.0 * np.sin(2 * np.pi * t / 30.0) + 3.0 * np.sin(2 * np.pi * t / 2.3)


def readings(seed, seconds=60.0, rate=100.0, noise=0.017):
    t = np.arange(0.0, seconds, 1 / rate)
    return t, (load_force(t) - OFFSET) / SCALE + np.random.default_rng(seed).normal(0.0, noise, t.size)


def gauge_log(seed, lag=0.0, seconds=60.0, rate=10.0, noise=0.05):
    t = np.arange(0.0, seconds, 1 / rate)
    return t + lag, load_force(t) + np.random.default_rng(seed + 1000).normal(0.0, noise, t.size)


def correlated(rng, size, std, memory):
    """Gauss-Markov noise of standard deviation `std` and correlation time `memory` [samples]."""
    decay = np.exp(-1.0 / memory)
    noise = rng.normal(0.0, std * np.sqrt(1 - decay**2), size)
    noise[0] = rng.normal(0.0, std)
    for i in range(1, size):
        noise[i] += decay * noise[i - 1]
    return noise


def test_an_exact_line_is_recovered_exactly():
    force = np.linspace(-50.0, 150.0, 200)
    result = fit(force, SCALE * force + OFFSET)
    assert result.scale == pytest.approx(SCALE, abs=1e-12)
    assert result.offset == pytest.approx(OFFSET, abs=1e-10)
    assert (result.samples, result.residual_max) == (200, pytest.approx(0.0, abs=1e-10))


def test_white_residuals_give_the_textbook_standard_deviations():
    rng = np.random.default_rng(3)
    force = np.linspace(0.0, 200.0, 4000)
    result = fit(force, SCALE * force + OFFSET + rng.normal(0.0, 0.1, force.size))
    around = np.sum((force - force.mean()) ** 2)
    assert result.scale_std == pytest.approx(0.1 / np.sqrt(around), rel=0.1)
    assert result.offset_std == pytest.approx(0.1 * np.sqrt(1 / force.size + force.mean() ** 2 / around), rel=0.1)


def test_intervals_hold_when_residuals_are_correlated_in_time():
    rng = np.random.default_rng(11)
    t = np.arange(0.0, 120.0, 0.05)
    force = load_force(t)
    inside = []
    for _ in range(300):
        result = fit(force, SCALE * force + OFFSET + correlated(rng, t.size, 0.1, memory=20))
        inside.append(
            [
                abs(result.scale - SCALE) < 1.96 * result.scale_std,
                abs(result.offset - OFFSET) < 1.96 * result.offset_std,
            ]
        )
    coverage = np.mean(inside, axis=0)
    assert np.all(coverage > 0.88)  # plain least squares covers a quarter of them here
    assert np.all(coverage < 0.995)


@pytest.mark.parametrize("lag", [0.0, 0.37, -0.8])
def test_a_gauge_with_its_own_rate_and_clock_is_aligned(lag):
    result = fit_logs(*readings(1), *gauge_log(1, lag), max_lag=1.0)
    assert result.lag == pytest.approx(lag, abs=0.01)
    assert result.scale == pytest.approx(SCALE, abs=4 * result.scale_std)
    assert result.offset == pytest.approx(OFFSET, abs=4 * result.offset_std)
    assert result.scale_std < 1e-3


def test_samples_missing_in_a_log_are_left_out():
    force = np.linspace(0.0, 100.0, 100)
    reference = SCALE * force + OFFSET
    force[7] = reference[30] = np.nan
    assert fit(force, reference).samples == 98


def test_logs_that_determine_no_calibration_are_refused():
    with pytest.raises(GaugeError, match="at least 10"):
        fit(np.arange(9.0), np.arange(9.0))
    rest = np.random.default_rng(0).normal(20.0, 0.02, 1000)
    with pytest.raises(GaugeError, match="over its range"):
        fit(rest, rest)
    with pytest.raises(GaugeError, match="not later"):
        fit_logs(*readings(1), np.array([0.0, 2.0, 2.0]), np.zeros(3), 0.0)
    with pytest.raises(GaugeError, match="samples in common"):
        fit_logs(*readings(1), gauge_log(1)[0] + 1e6, gauge_log(1)[1], 0.0)
    with pytest.raises(GaugeError, match="align their stamps"):
        fit_logs(*readings(1), *gauge_log(1, lag=1.5), max_lag=1.0)


@pytest.fixture
def logs(tmp_path):
    for name, (stamp, force) in {"sensor": readings(5), "gauge": gauge_log(5, lag=0.2)}.items():
        write_columns(tmp_path / f"{name}.csv", {"stamp": stamp, "force": force})
    return tmp_path


def test_the_written_parameters_give_the_gauges_force(logs, capsys):
    before = logs / "rig.yaml"
    recorded_with = {"force_scale": 0.5, "force_offset": 2.0, "force_reversed": True}
    before.write_text(yaml.safe_dump({"/**/driver": {"ros__parameters": {"transmission_2": recorded_with}}}))
    out = logs / "calibrated.yaml"
    arguments = ["--reference", str(logs / "gauge.csv"), "--transmission", "transmission_2", "--config", str(before)]
    assert main([str(logs / "sensor.csv"), *arguments, "--out", str(out)]) == 0
    after = load(out, "driver", DriverSettings).transmission_2
    signal = np.array([-300.0, 5.0, 250.0])
    then = Calibration.of(0.5, 2.0, reverse=True)
    now = Calibration.of(after.force_scale, after.force_offset, after.force_reversed)
    np.testing.assert_allclose(now(signal), SCALE * then(signal) + OFFSET, atol=0.05)
    assert "scale" in capsys.readouterr().out


def test_a_sensor_of_opposite_sign_is_reversed(logs):
    stamp, force = readings(5)
    write_columns(logs / "sensor.csv", {"stamp": stamp, "force": -force})
    out = logs / "calibrated.yaml"
    assert main([str(logs / "sensor.csv"), "--reference", str(logs / "gauge.csv"), "--out", str(out)]) == 0
    after = load(out, "driver", DriverSettings).transmission_1
    assert after.force_reversed
    assert after.force_scale == pytest.approx(SCALE, rel=1e-3)


def test_a_file_with_both_columns_needs_no_reference(tmp_path, capsys):
    stamp, force = readings(2)
    write_columns(tmp_path / "both.csv", {"stamp": stamp, "force": force, "reference": load_force(stamp)})
    assert main([str(tmp_path / "both.csv")]) == 0
    printed = capsys.readouterr().out
    parameters = yaml.safe_load(printed[printed.index("# ") :])["/**/driver"]["ros__parameters"]["transmission_1"]
    assert parameters["force_scale"] == pytest.approx(SCALE, rel=1e-4)
    assert parameters["force_offset"] == pytest.approx(OFFSET, abs=0.01)


def test_a_bag_is_calibrated_like_a_table(logs):
    from geometry_msgs.msg import WrenchStamped
    from rclpy.serialization import serialize_message

    stamp, force = readings(5)
    bag = Recording(logs / "bag")
    bag.add("/vsa/transmission_1/force", "geometry_msgs/msg/WrenchStamped")
    message = WrenchStamped()
    for at, value in zip(stamp + 100.0, force, strict=True):
        message.header.stamp.sec, message.header.stamp.nanosec = int(at), int(at % 1.0 * 1e9)
        message.wrench.force.x = value
        bag.write("/vsa/transmission_1/force", int(at * 1e9), serialize_message(message))
    bag.close()
    gauge_stamp, gauge = gauge_log(5)
    write_columns(logs / "gauge.csv", {"stamp": gauge_stamp + 100.0, "force": gauge})
    out = logs / "calibrated.yaml"
    assert main([str(logs / "bag"), "--reference", str(logs / "gauge.csv"), "--out", str(out)]) == 0
    assert load(out, "driver", DriverSettings).transmission_1.force_scale == pytest.approx(SCALE, rel=1e-3)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["absent.csv", "--reference", "gauge.csv"], "absent.csv"),
        (["sensor.csv"], "reference"),
        (["sensor.csv", "--reference", "absent.csv"], "absent.csv"),
        (["bag"], "--reference"),
        (["sensor.csv", "--reference", "words.csv"], "words.csv: line 3"),
        (["sensor.csv", "--reference", "gauge.csv", "--config", "words.csv"], "words.csv"),
    ],
)
def test_unusable_input_is_an_error_of_one_line(logs, monkeypatch, capsys, arguments, words):
    (logs / "words.csv").write_text("stamp,force\n0,1\n1,much\n")
    monkeypatch.chdir(logs)
    assert main(arguments) == 1
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1
