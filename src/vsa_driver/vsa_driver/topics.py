# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Samples to topics."""

from geometry_msgs.msg import Vector3, Wrench, WrenchStamped
from rclpy.node import Node
from rclpy.publisher import Publisher
from sensor_msgs.msg import JointState
from std_msgs.msg import Header
from vsa_common.ros.cdr import write_counters
from vsa_common.ros.node import RELIABLE
from vsa_common.ros.throttle import ThrottledPublisher
from vsa_driver.acquisition.channel import JointSample, Measurement, MotorSample
from vsa_driver.message_template import MessageTemplate
from vsa_msgs.msg import CaptureCounters

_PLACEHOLDERS = (1.5e-200, 2.5e-200)  # values that occur nowhere else in a message


class TransmissionTopics:
    """Force and encoder of one transmission, with one stamp, and the sequence number of each sample."""

    def __init__(self, node: Node, name: str, frame_prefix: str) -> None:
        self._frame = frame_prefix + name
        self._wrench = _wrench(self._frame, force=Vector3(x=_PLACEHOLDERS[0]))
        self._position = _positions(self._frame, [name])
        self._force = node.create_publisher(WrenchStamped, f"{name}/force", RELIABLE)
        self._encoder = node.create_publisher(JointState, f"{name}/encoder", RELIABLE)
        self._counters = node.create_publisher(CaptureCounters, f"{name}/capture_counters", RELIABLE)
        self._batch: list[tuple[int, int]] = []  # stamp [ns] and sequence number
        self._successor: int | None = None  # sequence number after that of the last sample

    @property
    def publishers(self) -> list[Publisher]:
        """All publishers, for their destruction."""
        return [self._force, self._encoder, self._counters]

    def publish(self, sample: Measurement) -> None:
        """Publish one sample; its sequence number follows in a batch, or precedes it at the start and after a gap."""
        if sample.sequence is not None:
            self._batch.append((sample.stamp_ns, sample.sequence))
            if sample.sequence != self._successor:
                self.flush()
            self._successor = sample.sequence + 1
        self._force.publish(self._wrench.render(sample.stamp_ns, sample.force))
        self._encoder.publish(self._position.render(sample.stamp_ns, sample.deflection))

    def flush(self) -> None:
        """Publish the sequence numbers collected since the last call."""
        batch, self._batch = self._batch, []
        if batch:
            self._counters.publish(write_counters(self._frame, *zip(*batch, strict=True)))


class RigTopics:
    """Angle and torque of the joint, positions of the motors."""

    def __init__(self, node: Node, joint: str, motors: list[str], frame_prefix: str) -> None:
        self._angle = _positions(frame_prefix + joint, [joint])
        self._torque = _wrench(frame_prefix + joint, torque=Vector3(z=_PLACEHOLDERS[0]))
        self._motor = _positions(frame_prefix + "motors", motors)
        self._angles = ThrottledPublisher(node, JointState, "joint_states")
        self._torques = node.create_publisher(WrenchStamped, "external_torque", RELIABLE)
        self._motors = node.create_publisher(JointState, "motor_states", RELIABLE)

    @property
    def publishers(self) -> list[Publisher]:
        """All publishers, for their destruction."""
        return [*self._angles.publishers, self._torques, self._motors]

    def publish_joint(self, sample: JointSample) -> None:
        """Publish the measured quantities of the joint; the torque is about z."""
        if sample.angle is not None:
            self._angles.publish(sample.stamp_ns, self._angle.render(sample.stamp_ns, sample.angle))
        if sample.torque is not None:
            self._torques.publish(self._torque.render(sample.stamp_ns, sample.torque))

    def publish_motors(self, sample: MotorSample) -> None:
        """Publish the motor positions."""
        self._motors.publish(self._motor.render(sample.stamp_ns, *sample.positions))


def _positions(frame: str, names: list[str]) -> MessageTemplate:
    placeholders = list(_PLACEHOLDERS[: len(names)])
    message = JointState(header=Header(frame_id=frame), name=names, position=placeholders)
    return MessageTemplate(message, placeholders)


def _wrench(frame: str, **component: Vector3) -> MessageTemplate:
    message = WrenchStamped(header=Header(frame_id=frame), wrench=Wrench(**component))
    return MessageTemplate(message, _PLACEHOLDERS[:1])
