# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Names and frame_ids of the driver's messages."""

from types import SimpleNamespace

import pytest
from rclpy.serialization import deserialize_message
from vsa_common.config.configuration import ConfigurationError, build
from vsa_driver.acquisition.channel import JointSample, Measurement, MotorSample
from vsa_driver.settings import DriverSettings
from vsa_driver.topics import RigTopics, TransmissionTopics


class Node:
    """Collects the messages of its publishers by topic."""

    def __init__(self):
        self.messages = {}

    def create_publisher(self, kind, topic, _):
        return SimpleNamespace(publish=lambda data: self.messages.update({topic: deserialize_message(data, kind)}))


def published(joint, motors, frame_prefix):
    """The messages of one sample by topic."""
    node = Node()
    rig = RigTopics(node, joint, motors, frame_prefix)
    rig.publish_joint(JointSample(stamp_ns=1, angle=0.5, torque=0.25))
    rig.publish_motors(MotorSample(1, (1.0, 2.0), False))
    transmission = TransmissionTopics(node, "transmission_1", frame_prefix)
    transmission.publish(Measurement("transmission_1", 1, sequence=7, force=30.0, deflection=0.01))
    transmission.flush()
    return node.messages


def test_a_sequence_number_precedes_its_sample_at_the_start_and_after_a_gap():
    published = []
    publisher = lambda kind, topic, _: SimpleNamespace(  # noqa: E731
        publish=lambda data: published.append((topic.partition("/")[2], deserialize_message(data, kind)))
    )
    transmission = TransmissionTopics(SimpleNamespace(create_publisher=publisher), "transmission_1", "")
    for stamp_ns, sequence in ((1, 7), (2, 8), (3, 11), (4, 12)):
        transmission.publish(Measurement("transmission_1", stamp_ns, sequence, force=30.0, deflection=0.01))
    transmission.flush()
    batches = [list(message.counter) for topic, message in published if topic == "capture_counters"]
    assert batches == [[7], [8, 11], [12]]
    assert [topic for topic, _ in published if topic != "encoder"] == [
        "capture_counters", "force", "force", "capture_counters", "force", "force", "capture_counters",
    ]  # fmt: skip


def test_samples_without_a_sequence_number_have_no_batch():
    node = Node()
    transmission = TransmissionTopics(node, "transmission_1", "")
    transmission.publish(Measurement("transmission_1", 1, None, force=30.0, deflection=0.01))
    transmission.flush()
    assert node.messages.keys() == {"transmission_1/force", "transmission_1/encoder"}


@pytest.mark.parametrize("prefix", ["", "left/"])
def test_every_message_has_the_frame_id_and_the_names_of_the_parameters(prefix):
    messages = published("elbow", ["flexor", "extensor"], prefix)
    assert {topic: message.header.frame_id for topic, message in messages.items()} == {
        "joint_states": f"{prefix}elbow",
        "joint_states_throttle": f"{prefix}elbow",
        "external_torque": f"{prefix}elbow",
        "motor_states": f"{prefix}motors",
        "transmission_1/force": f"{prefix}transmission_1",
        "transmission_1/encoder": f"{prefix}transmission_1",
        "transmission_1/capture_counters": f"{prefix}transmission_1",
    }
    assert messages["joint_states"].name == ["elbow"]
    assert messages["motor_states"].name == ["flexor", "extensor"]
    assert list(messages["motor_states"].position) == [1.0, 2.0]


@pytest.mark.parametrize(
    ("parameter", "value", "expected"),
    [
        ("motors.names", ["one"], "must be 2 different names"),
        ("motors.names", ["one", "one"], "must be 2 different names"),
        ("motors.names", ["one", ""], "must be 2 different names"),
        ("joint.name", "", "must not be empty"),
    ],
)
def test_empty_and_equal_names_are_refused(parameter, value, expected):
    with pytest.raises(ConfigurationError, match=f"{parameter} = .*{expected}"):
        build(DriverSettings, {parameter: value})
