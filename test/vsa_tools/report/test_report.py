# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The report of a recording with known numbers, and of incomplete, truncated and foreign bags."""

import re
import shutil
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import numpy as np
import paper_run
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.serialization import serialize_message
from std_msgs.msg import String
from vsa_common.config.configuration import load
from vsa_common.io.bags import BagError, Recording
from vsa_common.io.tables import TableError
from vsa_estimator.initialization.previous_run import coefficients_of
from vsa_estimator.settings import Initial, NodeConfig
from vsa_tools.report import command as report
from vsa_tools.report.columns import first_stamp
from vsa_tools.report.data import read_run
from vsa_tools.report.downsampling import cloud, envelope, extremes
from vsa_tools.report.joint_figures import figure_joint
from vsa_tools.report.model_figures import elastic_law, figure_elastic_law, figure_laws, residual
from vsa_tools.report.panels import force_rate
from vsa_tools.report.tables import health_table, joint_table, table_1
from vsa_tools.report.transmission_figures import figure_coefficients, figure_impedance
from vsa_tools.report.truth import coefficients, read_truth

SECONDS, RATE = 4.0, 200.0


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    paper_run.write_run(folder / "bag", SECONDS, RATE)
    paper_run.write_truth(folder / "truth.csv", SECONDS, RATE)
    return folder / "bag"


@pytest.fixture(scope="module")
def run(bag):
    return read_run(bag)


@pytest.fixture(scope="module")
def written(bag, tmp_path_factory):
    out = tmp_path_factory.mktemp("report")
    report.write(bag, out)
    return out


def rows(table):
    return {tuple(row[:2]): row for row in table.rows}


def test_an_extreme_of_one_sample_remains_after_a_thousandfold_reduction():
    time = np.linspace(0.0, 1000.0, 1_000_001)
    value = np.sin(time)
    value[123_456], value[777_777] = 50.0, -60.0
    x, y = extremes(time, value)
    assert len(x) <= 1010
    assert (y.max(), y.min()) == (50.0, -60.0)
    assert x[y.argmax()] == time[123_456]
    assert np.all(np.diff(x) > 0.0)


def test_a_short_series_is_unchanged():
    x, y = extremes(np.array([0.0, 0.1, 0.2]), np.array([1.0, 3.0, 2.0]))
    assert x.tolist() == [0.0, 0.1, 0.2]
    assert y.tolist() == [1.0, 3.0, 2.0]


def test_a_line_is_interrupted_by_a_gap():
    time = np.concatenate([np.arange(100) * 0.01, 5.0 + np.arange(100) * 0.01])
    _, y = extremes(time, np.ones(200))
    assert np.flatnonzero(np.isnan(y)).tolist() == [100]


def test_an_envelope_contains_every_sample_of_its_band():
    time = np.arange(10_000) * 0.01
    low, high = np.cos(time) - np.abs(np.sin(99.0 * time)), np.cos(time) + 1.0
    x, least, greatest = envelope(time, low, high, points=100)
    for begin, end, a, b in zip(x, [*x[1:], np.inf], least, greatest, strict=True):
        inside = (time >= begin) & (time < end)
        assert a == low[inside].min()
        assert b == high[inside].max()


def test_a_cloud_keeps_the_extremes_of_every_bin():
    random = np.random.default_rng(3)
    x, y = random.uniform(0.0, 1.0, 50_000), random.standard_normal(50_000)
    a, b = cloud(x, y, bins=20)
    assert len(a) == 40
    assert (b.max(), b.min()) == (y.max(), y.min())


def test_force_rate_of_a_ramp_is_its_slope():
    time = np.arange(0.0, 3.0, 0.002)
    assert force_rate(time, 7.0 * time + 2.0)[-1] == pytest.approx(7.0, rel=1e-3)


def test_table_1_gives_the_coefficients_with_their_intervals_and_errors(bag, run):
    table = table_1(run.joints[0], read_truth(bag.parent / "truth.csv", run))
    k2 = rows(table)["transmission_1", "k2, exponent"]
    assert k2[2:5] == ["267.4", "1", "1/m"]  # 267.2 (1 + 0.3 0.002), 1.96 0.002 267.2
    assert k2[5] == "0.2674 ± 0.001 1/mm"
    assert k2[6] == "267.2"
    assert k2[7] == "+0.06 %"
    assert rows(table)["transmission_2", "d2, cubic damping"][6] == "-1.17e+08"
    assert rows(table)["transmission_1", "m, inertia"][2].startswith("(0.37")
    assert "inertia" in table.note


@pytest.mark.parametrize(
    ("stiffness", "damping", "names"),
    [
        (lambda x: 207.0 * np.exp(267.2 * x), lambda v: 4000.0 - 3.0 * 1.089e8 * v**2, {"k2", "d1", "d2", "inertia"}),
        (lambda x: 650.0 + 7.5e5 * x, lambda v: 4000.0 - 3.0 * 1.089e8 * v**2, {"d1", "d2", "inertia"}),
        (lambda x: np.full_like(x, 4567.8), lambda v: 4000.0 - 3.0 * 1.089e8 * v**2, {"d1", "d2", "inertia"}),
        (lambda x: 207.0 * np.exp(267.2 * x), lambda v: np.full_like(v, 4000.0), {"k2", "d1", "inertia"}),
        (lambda x: 207.0 * np.exp(267.2 * x), lambda v: 4000.0 / np.cosh(430.0 * v) ** 2, {"k2", "inertia"}),
    ],
    ids=("paper", "quadratic spring", "linear spring", "linear damper", "soft knee"),
)
def test_true_coefficients_are_those_that_describe_the_rig(stiffness, damping, names):
    time = np.linspace(0.0, 20.0, 2000)
    x, v = 0.010 + 0.004 * np.sin(0.5 * time), 0.002 * np.cos(0.5 * time)
    columns = {"deflection": x, "velocity": v, "inertia": np.full(2000, 0.4)}
    found = coefficients(columns | {"stiffness": stiffness(x), "damping": damping(v)})
    assert set(found) == names
    expected = {"k2": 267.2, "d1": 4000.0, "d2": -1.089e8, "inertia": 0.4}
    assert found == pytest.approx({name: expected[name] for name in names}, rel=1e-6)


@pytest.mark.parametrize("end", ["", "712", "712,3.5", "712,3.5,8e-", ",,", "712,nan\n", "712,3.5,0.008\n"])
def test_the_truth_of_a_file_that_was_cut_off_is_that_of_its_complete_rows(bag, run, tmp_path, end):
    rows_of_file = (bag.parent / "truth.csv").read_text().splitlines(keepends=True)[:712]
    (tmp_path / "truth.csv").write_text("".join(rows_of_file) + end)
    found = read_truth(tmp_path / "truth.csv", run)["/vsa", "transmission_1"]
    assert found.coefficients["k2"] == pytest.approx(267.2, rel=1e-6)
    assert found.coefficients["inertia"] == pytest.approx(0.3755)
    assert found.time[-1] == pytest.approx(710 / RATE)


def test_a_truth_without_a_complete_row_is_an_error(bag, run, tmp_path):
    header, first = (bag.parent / "truth.csv").read_text().splitlines()[:2]
    for text in (header, f"{header}\n", f"{header}\n{first[:60]}", f"{header}\n1,2\n"):
        (tmp_path / "truth.csv").write_text(text)
        with pytest.raises(TableError, match=r"truth\.csv: line [12]"):
            read_truth(tmp_path / "truth.csv", run)


def test_without_truth_table_1_has_no_empty_columns(run):
    table = table_1(run.joints[0], {})
    assert "truth" not in table.columns
    assert all(len(row) == len(table.columns) for row in table.rows)


def test_the_joint_table_covers_valid_samples_only(run):
    row = joint_table(run.joints[0]).rows[0]
    time = np.arange(SECONDS * RATE) / RATE
    late = time >= paper_run.VALID_AFTER
    stiffness = 0.0
    for side in (1, 2):
        sigma = paper_run.truth(side, time)["stiffness"][late]
        stiffness = stiffness + 0.0215**2 * sigma * 1e5 / (4e5 + sigma)
    assert row[1] == f"{stiffness.min():.4g} … {stiffness.max():.4g}"
    assert row[-1] == "50.0 %"


def test_the_band_of_the_joint_stiffness_is_symmetric_in_the_logarithm(run):
    joint = run.joints[0]
    axes = figure_joint(joint, run.duration).axes[0]
    band = axes.collections[0].get_paths()[0].vertices[:, 1]
    stiffness = joint.impedance["stiffness"]  # standard deviation 1 % of the value
    assert band.min() == pytest.approx(stiffness.min() * np.exp(-0.02), rel=2e-5)
    assert band.max() == pytest.approx(stiffness.max() * np.exp(0.02), rel=2e-5)


def test_a_truth_far_from_the_estimate_is_within_the_axes(bag, run):
    joint = run.joints[0]
    truths = read_truth(bag.parent / "truth.csv", run)
    for truth in truths.values():
        truth.columns["inertia"], truth.coefficients["inertia"] = np.full(len(truth.time), 7.5), 7.5
    side = joint.transmissions[0]
    impedance = figure_impedance(side, truths[joint.name, side.name], "k", run.duration)
    for mass in (impedance.axes[-1], figure_coefficients(joint, truths, run.duration).axes[-1]):
        low, high = mass.get_ylim()
        assert low < 0.3 and high > 7.5


def test_health_counts_the_lost_frame_and_the_delay(run):
    health = {row[0]: row[1:] for row in health_table(run.joints[0]).rows}
    assert health["lost on the bus, by counter"] == ["1", "1"]
    assert health["sample rate"] == ["200.0 Hz", "200.0 Hz"]
    assert health["stiffness first valid after"] == ["2.00 s", "2.00 s"]
    assert health["delay to the recorder, p99"] == ["2.00 ms", "2.00 ms"]
    assert health["force rejected by the gate"] == ["3", "3"]


def test_the_page_is_complete_and_has_no_external_resources(written):
    text = (written / "report.html").read_text()
    body = re.sub(r' xmlns(:\w+)?="[^"]*"| xlink:href="#[^"]*"', "", text)
    assert not re.search(r'(src|href)="(?!#)|url\((?!#)|@import|<script', body)
    for title in (
        "Fig. 7: motion of transmission_1",
        "Fig. 8: impedance of transmission_2",
        "Fig. 9",
        "Fig. 6",
        "Table I",
    ):
        assert title in text
    assert len(re.findall("transmission_[12]: (?:not )?white", text)) == 4  # two signals of two transmissions
    for fact in ("267.4", "lost on the bus", "matplotlib 3", "/vsa/estimator_1", "converging"):
        assert fact in text
    for svg in re.findall(r"<svg.*?</svg>", text, flags=re.DOTALL):
        ElementTree.fromstring(svg)
    assert len(re.findall("<svg", text)) == 10


def test_the_elastic_law_of_the_last_valid_state_leaves_the_noise_of_the_force_sensor(run):
    for number, side in enumerate(run.joints[0].transmissions, 1):
        law = elastic_law(side.state)
        x = np.linspace(0.006, 0.010, 9)
        offset, k1, k2, *_ = paper_run.LAWS[number]
        assert law.stiffness(x) == pytest.approx(k1 * k2 * np.exp(k2 * x), rel=1e-12)
        assert law.force(x) == pytest.approx(offset + k1 * np.exp(k2 * x), rel=1e-9)
        deflection, velocity, left = residual(side, law)
        assert 600 < len(left) < 800
        assert np.abs(velocity).min() > 3.0 * 2e-5
        smooth = np.array([np.median(left[np.abs(deflection - at) < 4e-4]) for at in x])
        true = paper_run.truth(number, np.arange(SECONDS * RATE) / RATE)
        by_motion = 2e-6 * true["stiffness"], 2e-5 * true["damping"]  # noise of the run's position and velocity
        assert np.std(left) == pytest.approx(np.sqrt(0.017**2 + sum(np.mean(one**2) for one in by_motion)), rel=0.1)
        assert np.abs(smooth).max() < 0.03


def test_a_law_of_any_form_is_drawn_through_its_knots(tmp_path, monkeypatch):
    knots, ln_stiffness = [0.004, 0.006, 0.009, 0.012], [6.0, 7.5, 8.0, 8.1]
    monkeypatch.setattr(paper_run, "exponential_knots", lambda side: (knots, ln_stiffness))
    monkeypatch.setattr(paper_run, "COVARIANCE", (1e-4 * np.eye(4)).ravel().tolist())
    paper_run.write_run(tmp_path / "bag", SECONDS, RATE)
    (joint,) = read_run(tmp_path / "bag").joints
    line = figure_laws(joint, {}).axes[0].get_lines()[-1]
    at = np.interp(1e3 * 0.007, *line.get_data())
    assert at == pytest.approx(1e-3 * np.exp(7.5 + 0.5 / 3.0), rel=1e-3)
    band = figure_laws(joint, {}).axes[0].collections[0].get_paths()[0].vertices
    assert band[:, 1].max() > at * np.exp(1.96 * 0.01)


def test_a_bag_of_a_version_without_elastic_law_has_no_such_figure(run):
    joint = run.joints[0]
    former = [replace(side, state=replace(side.state, flagged={})) for side in joint.transmissions]
    assert figure_elastic_law(replace(joint, transmissions=former)) is None
    assert figure_elastic_law(joint) is not None


def test_pdf_and_pictures_are_next_to_the_page(written):
    names = {path.stem for path in (written / "figures").glob("*.png")}
    assert {"fig7_transmission_1", "fig8_transmission_2", "fig9", "fig6", "table1", "joint", "health"} <= names
    assert "elastic_law" in names
    assert len(re.findall(rb"/Type /Page\b", (written / "report.pdf").read_bytes())) == 1 + len(names)


def test_a_bag_of_sensors_alone_has_motion_and_health_figures(tmp_path):
    paper_run.write_run(tmp_path / "bag", 1.0, leaves=("force", "encoder"), space="/left/arm")
    text = report.write(tmp_path / "bag", tmp_path / "out").read_text()
    assert "sensors only" in text
    assert {path.stem for path in (tmp_path / "out" / "figures").glob("*")} == {
        "fig7_transmission_1", "fig7_transmission_2", "health",
    }  # fmt: skip


def test_a_truth_that_cannot_be_assigned_is_a_warning(bag, tmp_path):
    paper_run.write_run(tmp_path / "bag", 1.0, leaves=("force", "encoder", "impedance", "estimator_state"))
    text = "transmission_1: without capture_counters the truth cannot be assigned to its samples"
    with_truth = report.write(tmp_path / "bag", tmp_path / "out", bag.parent / "truth.csv", print_files=False)
    assert text in with_truth.read_text()
    assert text not in report.write(tmp_path / "bag", tmp_path / "out", print_files=False).read_text()
    assert text not in report.write(bag, tmp_path / "out", print_files=False).read_text()


def test_messages_before_the_first_sample_do_not_set_the_begin():
    begin = paper_run.START_NS
    assert first_stamp([0] * 50 + [begin + k * 10**7 for k in range(100)]) == begin


def test_a_truncated_recording_is_read_to_its_end(bag, tmp_path):
    shutil.copytree(bag, tmp_path / "bag")
    (tmp_path / "bag" / "metadata.yaml").unlink()
    file = next((tmp_path / "bag").glob("*.mcap"))
    file.write_bytes(file.read_bytes()[: file.stat().st_size * 2 // 3])
    run = read_run(tmp_path / "bag")
    assert not run.complete
    assert 1.0 < run.duration < 3.5
    assert "cut off" in report.warnings(run)[0]


def test_a_foreign_bag_is_a_one_line_error_that_lists_its_topics(tmp_path, capsys):
    recording = Recording(tmp_path / "bag")
    recording.add("/chatter", "std_msgs/msg/String")
    recording.write("/chatter", 1, serialize_message(String(data="hello")))
    recording.close()
    assert report.main([str(tmp_path / "bag")]) == 1
    error = capsys.readouterr().err
    assert "/chatter (std_msgs/msg/String)" in error
    assert error.count("\n") == 1


def test_an_empty_bag_and_a_missing_one_are_one_line_errors(tmp_path, capsys):
    recording = Recording(tmp_path / "bag")
    recording.add("/vsa/joint_impedance", "vsa_msgs/msg/JointImpedance")
    recording.close()
    for name in ("bag", "absent"):
        assert report.main([str(tmp_path / name)]) == 1
        error = capsys.readouterr().err
        assert error.count("\n") == 1
        assert str(tmp_path / name) in error


def test_a_text_file_is_not_a_bag(tmp_path):
    (tmp_path / "notes.mcap").write_text("not a recording")
    with pytest.raises(BagError, match=r"notes\.mcap"):
        read_run(tmp_path / "notes.mcap")


def test_an_outlier_of_the_stamps_does_not_extend_the_time_axis(tmp_path, bag):
    recording = Recording(tmp_path / "bag")
    message = paper_run.WrenchStamped()
    recording.add("/vsa/transmission_1/force", "geometry_msgs/msg/WrenchStamped")
    for k in range(100):
        paper_run.set_stamp(message.header.stamp, 0 if k == 50 else paper_run.START_NS + k * 10**7)
        recording.write("/vsa/transmission_1/force", paper_run.START_NS + k * 10**7, serialize_message(message))
    recording.close()
    run = read_run(tmp_path / "bag")
    assert run.duration == pytest.approx(0.99)
    assert np.isnan(run.joints[0].transmissions[0].force.time[50])


@pytest.mark.parametrize("stamped", [True, False])
def test_the_time_of_a_diagnostic_counts_from_the_first_sample(tmp_path, stamped):
    recording = Recording(tmp_path / "bag")
    wrench, text = paper_run.WrenchStamped(), DiagnosticArray()
    text.status = [DiagnosticStatus(level=bytes([1]), name="/vsa/driver", message="late")]
    recording.add("/vsa/transmission_1/force", "geometry_msgs/msg/WrenchStamped")
    recording.add("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")
    for k in range(5):
        now_ns = paper_run.START_NS + k * 10**9
        paper_run.set_stamp(wrench.header.stamp, now_ns)
        recording.write("/vsa/transmission_1/force", now_ns, serialize_message(wrench))
        if k >= 3:
            if stamped:
                paper_run.set_stamp(text.header.stamp, now_ns)
            recording.write("/diagnostics", now_ns, serialize_message(text))
    recording.close()
    (diagnostic,) = read_run(tmp_path / "bag").diagnostics
    assert (diagnostic.first, diagnostic.count) == (3.0, 2)


def test_the_coefficients_at_the_end_are_a_parameter_file_of_both_estimators(written, run):
    for side in (1, 2):
        posterior = load(written / "coefficients.yaml", f"estimator_{side}", NodeConfig).initial.posterior
        state = run.joints[0].transmissions[side - 1].state
        assert dict(zip(posterior.names, posterior.values, strict=True))["k2"] == state["k2"][-1]
        assert posterior.covariance[8] == state["k2_variance"][-1]
        assert posterior.deflection_reference == 0.008
        assert coefficients_of(Initial(posterior=posterior)) is not None


def test_a_recording_without_valid_stiffness_gives_no_coefficients(tmp_path):
    paper_run.write_run(tmp_path / "bag", 1.0, RATE)  # not valid before paper_run.VALID_AFTER
    (tmp_path / "coefficients.yaml").write_text("of an earlier report")
    report.write(tmp_path / "bag", tmp_path, print_files=False)
    assert not (tmp_path / "coefficients.yaml").exists()
