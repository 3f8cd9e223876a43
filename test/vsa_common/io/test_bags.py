# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Bags: written here and read by another library, and the reverse."""

import shutil
from pathlib import Path

import pytest
import yaml
from geometry_msgs.msg import WrenchStamped
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import JointState
from vsa_common.io import bags
from vsa_msgs.msg import JointImpedance

FORCE = "/vsa/transmission_1/force"
JOINT = "/vsa/joint_impedance"


def wrench(force: float) -> bytes:
    message = WrenchStamped()
    message.header.frame_id = "transmission_1"
    message.wrench.force.x = force
    return serialize_message(message)


def write_bag(path: Path, count: int = 100, closed: bool = True) -> bags.Recording:
    recording = bags.Recording(path)
    recording.add(FORCE, "geometry_msgs/msg/WrenchStamped")
    recording.add(JOINT, "vsa_msgs/msg/JointImpedance")
    for k in range(count):
        recording.write(FORCE, 1_000 + k, wrench(float(k)))
        recording.write(JOINT, 1_000 + k, serialize_message(JointImpedance(stiffness=2.0 * k, tension=[1.0, float(k)])))
    if closed:
        recording.close()
    return recording


def test_written_messages_are_read_back_in_order(tmp_path):
    write_bag(tmp_path / "bag")
    read = list(bags.read(tmp_path / "bag"))
    assert [ns for _, ns, _ in read] == sorted(1_000 + k for k in range(100) for _ in range(2))
    assert [m.wrench.force.x for topic, _, m in read if topic == FORCE] == [float(k) for k in range(100)]
    assert [m.tension[1] for topic, _, m in read if topic == JOINT] == [float(k) for k in range(100)]


def test_only_selected_topics_are_read(tmp_path):
    write_bag(tmp_path / "bag")
    assert {topic for topic, _, _ in bags.read(tmp_path / "bag", [JOINT])} == {JOINT}
    assert list(bags.read(tmp_path / "bag", ["/absent"])) == []


def test_a_second_library_reads_the_same_numbers(tmp_path):
    write_bag(tmp_path / "bag")
    with (tmp_path / "bag" / "bag.mcap").open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        forces = [m.wrench.force.x for _, c, _, m in reader.iter_decoded_messages() if c.topic == FORCE]
    assert forces == [float(k) for k in range(100)]


def test_surplus_bytes_after_a_message_are_removed_by_the_writer_and_skipped_by_the_reader(tmp_path):
    message = JointState(name=["transmission_1"], position=[0.5])
    message.header.frame_id = "transmission_1"
    data = serialize_message(message)  # by Fast DDS, with padding for absent velocities and efforts
    store = get_typestore(Stores.ROS2_JAZZY)
    with Writer(tmp_path / "raw", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        writer.write(writer.add_connection("/a", "sensor_msgs/msg/JointState", typestore=store), 1, data)
    assert [m.position[0] for _, _, m in bags.read(tmp_path / "raw")] == [0.5]
    recording = bags.Recording(tmp_path / "recorded")
    recording.add("/a", "sensor_msgs/msg/JointState")
    recording.write("/a", 1, data)
    recording.close()
    with Reader(tmp_path / "recorded") as reader:  # rejects surplus bytes
        [(connection, _, written)] = reader.messages()
        assert store.deserialize_cdr(written, connection.msgtype).position[0] == 0.5


def test_metadata_is_that_of_rosbag2_of_jazzy(tmp_path):
    write_bag(tmp_path / "bag")
    info = yaml.safe_load((tmp_path / "bag" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert (info["version"], info["storage_identifier"], info["message_count"]) == (9, "mcap", 200)
    topic = info["topics_with_message_count"][0]["topic_metadata"]
    assert topic["name"] == FORCE
    assert topic["serialization_format"] == "cdr"
    assert topic["type_description_hash"].startswith("RIHS01_")
    assert topic["offered_qos_profiles"][0]["reliability"] == "reliable"


def test_topics_have_types_and_counts(tmp_path):
    write_bag(tmp_path / "bag", 7)
    assert bags.topics(tmp_path / "bag")[JOINT] == bags.Topic(JOINT, "vsa_msgs/msg/JointImpedance", 7)


def test_messages_flushed_before_a_crash_are_readable(tmp_path):
    recording = write_bag(tmp_path / "bag", 50, closed=False)
    recording.flush()
    shutil.copytree(tmp_path / "bag", tmp_path / "crashed")
    recording.write(FORCE, 5_000, wrench(1.0))
    recording.abort()
    assert len(list(bags.read(tmp_path / "crashed"))) == 100
    assert bags.topics(tmp_path / "crashed")[FORCE].messages == 50


@pytest.mark.parametrize("kept", [0.3, 0.9, 0.999])
def test_a_truncated_file_yields_the_messages_before_its_end(tmp_path, kept):
    recording = write_bag(tmp_path / "bag", 0, closed=False)
    for k in range(40):
        recording.write(FORCE, 1_000 + k, wrench(float(k)))
        recording.flush()
    recording.close()
    whole = (tmp_path / "bag" / "bag.mcap").read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[: int(len(whole) * kept)])
    forces = [message.wrench.force.x for _, _, message in bags.read(cut)]
    assert forces == [float(k) for k in range(len(forces))]
    assert len(forces) >= int(40 * kept * 0.5)


def test_a_database_of_another_recorder_is_read(tmp_path):
    store = get_typestore(Stores.ROS2_JAZZY)
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connection = writer.add_connection("/ft", "geometry_msgs/msg/WrenchStamped", typestore=store)
        writer.write(connection, 5, wrench(12.5))
    [(topic, receive_ns, message)] = bags.read(tmp_path / "bag")
    assert (topic, receive_ns, message.wrench.force.x) == ("/ft", 5, 12.5)
    (tmp_path / "bag" / "metadata.yaml").unlink()
    assert [m.wrench.force.x for _, _, m in bags.read(tmp_path / "bag")] == [12.5]


def test_raw_bytes_are_read_back_unchanged(tmp_path):
    write_bag(tmp_path / "bag", 3)
    assert [data for _, _, data in bags.read_raw(tmp_path / "bag", [FORCE])] == [wrench(float(k)) for k in range(3)]


@pytest.mark.parametrize("content", [b"", b"not a bag", b"\x89MCAP0\r\n"])
def test_a_file_that_is_no_bag_is_rejected_by_name(tmp_path, content):
    (tmp_path / "x.mcap").write_bytes(content)
    with pytest.raises(bags.BagError, match=r"x\.mcap"):
        list(bags.read(tmp_path / "x.mcap"))


def test_absent_and_empty_folders_are_rejected(tmp_path):
    with pytest.raises(bags.BagError, match="no such bag"):
        list(bags.read(tmp_path / "absent"))
    with pytest.raises(bags.BagError, match=r"metadata\.yaml"):
        list(bags.read(tmp_path))


def test_an_existing_bag_is_not_overwritten(tmp_path):
    write_bag(tmp_path / "bag", 1)
    with pytest.raises(bags.BagError, match="exists"):
        bags.Recording(tmp_path / "bag")


def test_a_type_without_definition_is_rejected(tmp_path):
    with pytest.raises(bags.BagError, match=r"other_msgs/msg/Thing"):
        bags.Recording(tmp_path / "bag").add("/thing", "other_msgs/msg/Thing")


def test_the_files_of_an_unfinished_split_recording_are_read_in_the_order_of_their_numbers(tmp_path):
    (tmp_path / "split").mkdir()
    for number in range(12):
        recording = bags.Recording(tmp_path / "part")
        recording.add(FORCE, "geometry_msgs/msg/WrenchStamped")
        recording.write(FORCE, 1_000 + number, wrench(float(number)))
        recording.close()
        (tmp_path / "part" / "part.mcap").rename(tmp_path / "split" / f"bag_{number}.mcap")
        shutil.rmtree(tmp_path / "part")
    forces = [message.wrench.force.x for _, _, message in bags.read(tmp_path / "split")]
    assert forces == [float(number) for number in range(12)]
