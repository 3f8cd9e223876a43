# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The command `replay`: equal to the live estimator, and errors of unusable files."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import WrenchStamped
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from transmission_data import MULTISINE, TRANSMISSION_1, record
from vsa_common.io import bags
from vsa_common.io.tables import read_columns, write_columns
from vsa_common.ros.cdr import write_counters
from vsa_common.types import Status
from vsa_estimator.cli import replay as replay_tool
from vsa_estimator.cli.identify import main as identify_command
from vsa_estimator.cli.noise import main as noise_command
from vsa_estimator.cli.replay import FIELDS, main
from vsa_estimator.estimator import Estimator
from vsa_estimator.offline.recordings import is_complete, read_recordings
from vsa_estimator.output.estimate import ROW, row_of
from vsa_estimator.preprocessing.sequence_gaps import SequenceGaps
from vsa_estimator.settings import EstimatorConfig, NodeConfig

SECONDS = 12.0
COLUMNS = (
    "stamp,deflection,velocity,acceleration,stiffness,stiffness_std,damping,damping_std,inertia,inertia_std,k2,k2_std,"
    "d2,d2_std,force_offset,coulomb_friction,status,stiffness_valid,damping_valid,inertia_valid"
)


@pytest.fixture(autouse=True)
def defaults_only(monkeypatch):
    monkeypatch.setattr(replay_tool, "_installed_configuration", list)


@pytest.fixture(scope="module")
def samples():
    return record(TRANSMISSION_1, MULTISINE, SECONDS)


def write_csv(path: Path, data) -> Path:
    write_columns(path, {"stamp": data.stamp_ns / 1e9, "force": data.force, "deflection": data.deflection})
    return path


def write_mcap(path: Path, data, close: bool = True) -> Path:
    """A bag as the recorder writes it, force and encoder of both transmissions."""
    recording = bags.Recording(path)
    for side in (1, 2):
        recording.add(f"/vsa/transmission_{side}/force", "geometry_msgs/msg/WrenchStamped")
        recording.add(f"/vsa/transmission_{side}/encoder", "sensor_msgs/msg/JointState")
    for stamp_ns, force, deflection in zip(data.stamp_ns.tolist(), data.force, data.deflection, strict=True):
        for side in (1, 2):
            wrench, encoder = messages(stamp_ns, force, deflection)
            recording.write(f"/vsa/transmission_{side}/force", stamp_ns, serialize_message(wrench))
            recording.write(f"/vsa/transmission_{side}/encoder", stamp_ns, serialize_message(encoder))
    recording.flush()
    if close:
        recording.close()
    return path


def messages(stamp_ns: int, force: float, deflection: float, frame="transmission_1"):
    wrench, encoder = WrenchStamped(), JointState(name=["rod"], position=[float(deflection)])
    wrench.wrench.force.x = float(force)
    for message in (wrench, encoder):
        message.header.frame_id = frame
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, 1_000_000_000)
    return wrench, encoder


def live(data):
    estimator = Estimator(EstimatorConfig())
    return [estimator.add(*sample) for sample in zip(
        data.stamp_ns.tolist(), data.force.tolist(), data.deflection.tolist(), strict=True)]  # fmt: skip


def assert_same(file: Path, estimates):
    table = read_columns(file, COLUMNS.split(","))
    for column, field in FIELDS.items():
        expected = np.array([getattr(estimate, field) for estimate in estimates], float)
        expected = np.sqrt(expected) if column.endswith("_std") else expected
        np.testing.assert_allclose(table[column], expected, rtol=1e-12, atol=0.0, err_msg=column)


def test_a_csv_file_gives_the_estimates_of_the_live_estimator(tmp_path, samples):
    assert main([str(write_csv(tmp_path / "run.csv", samples)), "--out", str(tmp_path / "out")]) == 0
    assert (tmp_path / "out/transmission_1.csv").read_text().splitlines()[0] == COLUMNS
    assert_same(tmp_path / "out/transmission_1.csv", live(samples))


def test_a_bag_gives_the_estimates_of_the_live_estimator(tmp_path, samples):
    assert main([str(write_mcap(tmp_path / "bag", samples)), "--out", str(tmp_path / "out")]) == 0
    for side in (1, 2):
        assert_same(tmp_path / f"out/transmission_{side}.csv", live(samples))
    summary = json.loads((tmp_path / "out/summary.json").read_text())
    assert summary["transmission_2"]["rows_used"] == summary["transmission_2"]["rows_read"] == len(samples.force)


def write_counted(path, samples, stamp_ns, numbers):
    """A bag of samples [ns, N, m], with sequence numbers of the stamps (n,) [ns]."""
    recording = bags.Recording(path)
    topics = {"force": "geometry_msgs/msg/WrenchStamped", "encoder": "sensor_msgs/msg/JointState",
              "capture_counters": "vsa_msgs/msg/CaptureCounters"}  # fmt: skip
    for name, kind in topics.items():
        recording.add(f"/vsa/transmission_1/{name}", kind)
    for sample in samples:
        for name, message in zip(topics, messages(*sample), strict=False):
            recording.write(f"/vsa/transmission_1/{name}", sample[0], serialize_message(message))
    for part in np.array_split(np.arange(len(numbers)), 20):
        batch = write_counters("transmission_1", stamp_ns[part].tolist(), numbers[part].tolist())
        recording.write("/vsa/transmission_1/capture_counters", int(stamp_ns[part[-1]]), batch)
    recording.close()


def test_samples_that_a_bag_lacks_are_lost(tmp_path):
    data = record(TRANSMISSION_1, MULTISINE, 4.0)
    kept = np.flatnonzero(np.random.default_rng(3).uniform(size=len(data.force)) > 0.4)
    numbers = 1000 + np.arange(len(data.force)) + 5 * (np.arange(len(data.force)) >= kept[50])  # 5 lost on the bus
    samples = [(int(data.stamp_ns[k]), float(data.force[k]), float(data.deflection[k])) for k in kept]
    write_counted(tmp_path / "bag", samples, np.asarray(data.stamp_ns), numbers)
    (read,) = read_recordings(tmp_path / "bag")
    np.testing.assert_array_equal(read.lost, np.diff(numbers[kept], prepend=999) - 1)


def test_samples_that_the_driver_counts_as_lost_are_used_as_live(tmp_path):
    """Stamps of a host that delays them by up to 60 ms, every hundredth sample lost on the bus."""
    data, rng = record(TRANSMISSION_1, MULTISINE, SECONDS), np.random.default_rng(3)
    begins = np.sort(rng.uniform(0, len(data.force), 40).astype(int))
    for begin in begins:
        end = int(data.stamp_ns[begin]) + int(60e6 * rng.uniform())
        waiting = np.flatnonzero((data.stamp_ns < end) & (np.arange(len(data.force)) >= begin))
        data.stamp_ns[waiting] = end + 20_000 * np.arange(len(waiting))
    received = np.flatnonzero(rng.uniform(size=len(data.force)) > 0.01)
    stamp_ns, force, deflection = (np.asarray(one)[received] for one in (data.stamp_ns, data.force, data.deflection))
    estimator, gaps, expected = Estimator(EstimatorConfig()), SequenceGaps(), []
    estimator.count_lost(0)
    gaps.add(stamp_ns.tolist(), received.tolist())
    samples = list(zip(stamp_ns.tolist(), force.tolist(), deflection.tolist(), strict=True))
    for sample in samples:
        if lost := gaps.lost_before(sample[0]):
            estimator.count_lost(lost)
        expected.append(estimator.add(*sample))
    write_counted(tmp_path / "bag", samples, stamp_ns, received)
    assert main([str(tmp_path / "bag"), "--out", str(tmp_path / "out")]) == 0
    assert_same(tmp_path / "out/transmission_1.csv", expected)
    (without,) = read_recordings(write_csv(tmp_path / "run.csv", data))
    (read,) = read_recordings(tmp_path / "bag")
    assert without.lost is None
    assert read.lost.sum() == received[-1] - received[0] + 1 - len(received)


def test_many_samples_at_once_give_the_estimates_of_single_samples():
    data = record(TRANSMISSION_1, MULTISINE, 40.0, rate=1000)
    stamp_ns, force, deflection = data.stamp_ns.copy(), data.force.copy(), data.deflection.copy()
    force[20_000] = deflection[21_000] = np.nan
    force[22_000] += 5.0  # an outlier
    deflection[23_000:23_800] = deflection[23_000]  # stuck
    stamp_ns[25_000] = stamp_ns[24_999]
    stamp_ns[26_000:] += 400_000_000  # a gap
    deflection[30_000:] += 2e-3  # an encoder step
    stamp_ns[36_000:] -= 20_000_000_000  # a step back of the clock
    one, all_at_once = Estimator(EstimatorConfig()), Estimator(EstimatorConfig())
    expected = [row_of(one.add(*sample)) for sample in zip(
        stamp_ns.tolist(), force.tolist(), deflection.tolist(), strict=True)]  # fmt: skip
    ends = np.cumsum(np.random.default_rng(5).integers(1, 3000, 40))
    parts = np.split(np.arange(len(force)), ends[ends < len(force)])
    rows = np.concatenate([all_at_once.add_many(stamp_ns[part], force[part], deflection[part]) for part in parts])
    values = rows.view("f8").reshape(len(rows), -1)
    np.testing.assert_array_equal(values, np.array([np.broadcast_to(row, len(ROW)) for row in expected]))
    assert np.isnan(rows["status"]).sum() == 3
    assert {Status.CONVERGING, Status.VALID, Status.DEGRADED} <= set(rows["status"])
    assert all_at_once.state() == one.state()
    later_ns = int(stamp_ns[-1]) + 30_000_000
    assert all_at_once.predict_to(later_ns) == one.predict_to(later_ns)


@pytest.fixture
def two_joints(tmp_path):
    """A bag of the joints /left and /right, with a transmission of the same name and other forces."""
    recording = bags.Recording(tmp_path / "two")
    for joint in ("left", "right"):
        recording.add(f"/{joint}/transmission_1/force", "geometry_msgs/msg/WrenchStamped")
        recording.add(f"/{joint}/transmission_1/encoder", "sensor_msgs/msg/JointState")
    for joint, force in (("left", 30.0), ("right", 50.0)):
        for topic, message in zip(("force", "encoder"), messages(1_000_000_000, force, 0.01), strict=True):
            recording.write(f"/{joint}/transmission_1/{topic}", 1_000_000_000, serialize_message(message))
    recording.close()
    return tmp_path / "two"


@pytest.mark.parametrize("command", [main, noise_command, identify_command])
def test_two_joints_with_the_same_transmission_are_refused_without_a_namespace(two_joints, tmp_path, capsys, command):
    assert command([str(two_joints), "--out", str(tmp_path / "out.yaml")]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "/left/transmission_1/force and /right/transmission_1/force" in error
    assert "--namespace" in error


@pytest.mark.parametrize(("namespace", "force"), [("/left", 30.0), ("right", 50.0)])
def test_the_namespace_selects_the_joint(two_joints, tmp_path, namespace, force):
    (recording,) = read_recordings(two_joints, None, namespace)
    assert recording.force == [force]
    assert main([str(two_joints), "--namespace", namespace, "--out", str(tmp_path / "out")]) == 0
    assert (tmp_path / "out/transmission_1.csv").exists()


def test_an_unknown_namespace_is_named_in_the_error(two_joints, tmp_path, capsys):
    assert main([str(two_joints), "--namespace", "/middle", "--out", str(tmp_path / "out")]) == 1
    assert "/middle/transmission_N/force" in capsys.readouterr().err


def test_an_sqlite_bag_is_read(tmp_path, samples):
    store = get_typestore(Stores.ROS2_JAZZY)
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        topics = {"force": "geometry_msgs/msg/WrenchStamped", "encoder": "sensor_msgs/msg/JointState"}
        connections = [
            writer.add_connection(f"/rig/transmission_7/{name}", kind, typestore=store) for name, kind in topics.items()
        ]
        for stamp_ns, force, deflection in zip(
            samples.stamp_ns.tolist(), samples.force, samples.deflection, strict=True
        ):
            for connection, message in zip(connections, messages(stamp_ns, force, deflection), strict=True):
                writer.write(connection, stamp_ns, serialize_message(message))
    (recording,) = read_recordings(tmp_path / "bag")
    assert recording.transmission == "transmission_7"
    np.testing.assert_array_equal(recording.force, samples.force)
    np.testing.assert_array_equal(recording.deflection, samples.deflection)


def test_a_truncated_bag_is_replayed_and_reported(tmp_path, samples, capsys):
    bag = write_mcap(tmp_path / "bag", samples, close=False)
    assert not is_complete(bag)
    assert main([str(bag), "--out", str(tmp_path / "out")]) == 1
    assert "cut off" in capsys.readouterr().err
    with (tmp_path / "out/transmission_1.csv").open() as file:
        assert sum(1 for _ in csv.reader(file)) == len(samples.force) + 1


@pytest.mark.parametrize("command", [noise_command, identify_command])
def test_a_truncated_bag_is_used_and_reported(tmp_path, samples, capsys, command):
    bag = write_mcap(tmp_path / "bag", samples, close=False)
    assert command([str(bag), "--transmission", "transmission_1", "--out", str(tmp_path / "out")]) == 1
    printed = capsys.readouterr()
    assert "wrote" in printed.out
    assert printed.err.count("\n") == 1
    assert "bag: the bag was cut off" in printed.err


def test_invalid_rows_are_dropped_and_counted(tmp_path, samples):
    stamp, force = samples.stamp_ns / 1e9, samples.force.copy()
    stamp[100] = stamp[99]
    stamp[201], stamp[200] = stamp[200], stamp[201]
    force[300] = np.nan
    write_columns(tmp_path / "run.csv", {"stamp": stamp, "force": force, "deflection": samples.deflection})
    assert main([str(tmp_path / "run.csv"), "--out", str(tmp_path / "out")]) == 0
    summary = json.loads((tmp_path / "out/summary.json").read_text())["transmission_1"]
    assert (summary["rows_read"], summary["rows_dropped"]) == (len(stamp), 3)
    table = read_columns(tmp_path / "out/transmission_1.csv", ["stamp", "stiffness"])
    assert len(table["stamp"]) == len(stamp) - 3
    assert np.all(np.diff(table["stamp"]) > 0.0)
    assert np.isfinite(table["stiffness"]).all()


def test_a_single_row_is_replayed(tmp_path):
    (tmp_path / "run.csv").write_text("stamp,force,deflection\n0.0,30.0,0.01\n")
    assert main([str(tmp_path / "run.csv"), "--out", str(tmp_path / "out")]) == 0
    table = read_columns(tmp_path / "out/transmission_1.csv", COLUMNS.split(","))
    assert table["stamp"] == [0.0]
    assert table["stiffness_valid"] == [0.0]


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("stamp,force\n0.0,1.0\n", "line 1"),
        ("stamp,force,deflection\n", "line 2"),
        ("stamp,force,deflection\n0.0,1.0,0.01\n0.1,abc,0.01\n", "line 3"),
        ("stamp,force,deflection\n,1.0,0.01\n", "line 2"),
        ("", "line 1"),
    ],
)
def test_an_invalid_file_is_named_in_one_line(tmp_path, capsys, text, named):
    (tmp_path / "bad.csv").write_text(text)
    assert main([str(tmp_path / "bad.csv"), "--out", str(tmp_path / "out")]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "bad.csv" in error
    assert named in error


@pytest.mark.parametrize("name", ["nothing.csv", "nothing", "nothing.mcap", "notes.txt"])
def test_a_missing_input_is_named_in_the_error(tmp_path, capsys, name):
    assert main([str(tmp_path / name), "--out", str(tmp_path / "out")]) == 1
    assert name in capsys.readouterr().err


def test_an_unknown_transmission_is_answered_by_those_in_the_bag(tmp_path, samples, capsys):
    bag = write_mcap(tmp_path / "bag", samples)
    assert main([str(bag), "--transmission", "transmission_3", "--out", str(tmp_path / "out")]) == 1
    assert "transmission_1, transmission_2" in capsys.readouterr().err


def write_other_types(path: Path, kinds, data) -> Path:
    recording = bags.Recording(path)
    for (leaf, kind), one in zip(kinds.items(), data, strict=True):
        recording.add(f"/vsa/transmission_1/{leaf}", kind)
        recording.write(f"/vsa/transmission_1/{leaf}", 1, one)
    recording.close()
    return path


def test_topics_with_the_names_of_sensors_and_other_types_are_not_read(tmp_path, capsys):
    kinds = {"force": "std_msgs/msg/String", "encoder": "std_msgs/msg/String"}
    text = serialize_message(String(data="long enough to be read as a stamp, a name and some numbers behind it"))
    bag = write_other_types(tmp_path / "bag", kinds, [text, text])
    assert main([str(bag), "--out", str(tmp_path / "out")]) == 1
    error = capsys.readouterr().err
    assert (error.count("\n"), "WrenchStamped" in error) == (1, True)


@pytest.mark.parametrize("length", [0, 1, 3, 30])
def test_a_truncated_message_is_reported_in_one_line(tmp_path, capsys, length):
    kinds = {"force": "geometry_msgs/msg/WrenchStamped", "encoder": "sensor_msgs/msg/JointState"}
    wrench, encoder = map(serialize_message, messages(1_000_000_000, 1.0, 0.01))
    bag = write_other_types(tmp_path / "bag", kinds, [wrench[:length], encoder])
    assert main([str(bag), "--out", str(tmp_path / "out")]) == 1
    error = capsys.readouterr().err
    assert (error.count("\n"), "transmission_1/force: a message ends too early" in error) == (1, True)


def test_truncated_sequence_numbers_are_reported_in_one_line(tmp_path, capsys):
    recording = bags.Recording(tmp_path / "cut")
    recording.add("/vsa/transmission_1/capture_counters", "vsa_msgs/msg/CaptureCounters")
    for topic, kind in (("force", "geometry_msgs/msg/WrenchStamped"), ("encoder", "sensor_msgs/msg/JointState")):
        recording.add(f"/vsa/transmission_1/{topic}", kind)
    recording.write("/vsa/transmission_1/capture_counters", 1, b"\0\1\0\0" + bytes(9))
    recording.close()
    assert main([str(tmp_path / "cut"), "--out", str(tmp_path / "out")]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "capture_counters: a message ends too early" in error


def test_a_parameter_file_overrides_the_defaults(tmp_path):
    (tmp_path / "mine.yaml").write_text(
        "/**/estimator_2:\n  ros__parameters:\n    filter_rate: 50.0\n    initial:\n      k2: 165.6\n"
    )
    config = replay_tool.configuration("transmission_2", tmp_path / "mine.yaml")
    assert (config.filter_rate, config.initial.k2, config.initial.d1) == (50.0, 165.6, 4000.0)
    assert replay_tool.configuration("transmission_1", tmp_path / "mine.yaml").initial.k2 == 267.2


def test_the_installed_configuration_is_used_where_no_file_is_given(tmp_path, monkeypatch):
    (tmp_path / "rig.yaml").write_text(
        "/**/estimator_2:\n  ros__parameters: {filter_rate: 50.0, initial: {k2: 165.6}}\n"
    )
    (tmp_path / "mine.yaml").write_text("/**/estimator_2:\n  ros__parameters: {force_noise_std: 0.1}\n")
    monkeypatch.setattr(replay_tool, "_installed_configuration", lambda: [tmp_path / "rig.yaml"])
    installed = replay_tool.configuration("transmission_2", None)
    mine = replay_tool.configuration("transmission_2", tmp_path / "mine.yaml")
    default = NodeConfig()  # of the live node with --params-file mine.yaml
    assert (installed.filter_rate, installed.initial.k2) == (50.0, 165.6)
    assert mine == replace(default, force_noise_std=0.1)


def test_an_invalid_parameter_is_rejected(tmp_path, samples, capsys):
    (tmp_path / "mine.yaml").write_text("estimator_1:\n  ros__parameters:\n    filter_rate: -5.0\n")
    csv_file = write_csv(tmp_path / "run.csv", samples)
    assert main([str(csv_file), "--config", str(tmp_path / "mine.yaml"), "--out", str(tmp_path / "out")]) == 1
    assert "filter_rate" in capsys.readouterr().err


@pytest.mark.parametrize("key", ["/vsa/estimator_1", "estimator_1"])
def test_a_dump_of_a_running_node_is_a_configuration(tmp_path, key):
    file = tmp_path / "dump.yaml"
    file.write_text(
        f"{key}:\n  ros__parameters:\n    autostart: true\n    use_sim_time: false\n"
        "    start_type_description_service: true\n    realtime: {priority: 0, rest: 0.0}\n"
        "    qos_overrides: {/parameter_events: {publisher: {depth: 1000}}}\n"
        "    force_noise_std: 1e-2\n    deflection_noise_std: 1e-05\n    initial: {k2: 250, d1: '4e3'}\n"
        "/**:\n  ros__parameters: {of_another_node: 1}\n"
    )
    config = replay_tool.configuration("transmission_1", file)
    assert (config.force_noise_std, config.deflection_noise_std) == (1e-2, 1e-5)
    assert (config.initial.k2, config.initial.d1) == (250.0, 4000.0)
