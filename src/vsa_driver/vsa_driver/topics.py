"""Samples to topics. Each message exists once and is filled anew, so that a sample costs little."""

from array import array

from builtin_interfaces.msg import Time
from geometry_msgs.msg import WrenchStamped
from rclpy.node import Node
from rclpy.publisher import Publisher
from sensor_msgs.msg import JointState
from vsa_common.node import RELIABLE
from vsa_common.stamps import NANOSECONDS
from vsa_driver.capture import JointSample, MotorSample, Sample
from vsa_msgs.msg import CaptureCounters


class TransmissionTopics:
    """Force and encoder of one transmission, with one stamp, and which frame each came from."""

    def __init__(self, node: Node, name: str) -> None:
        self._wrench = WrenchStamped()
        self._encoder = JointState(name=[name], position=[0.0])
        self._counters = CaptureCounters()
        for message in (self._wrench, self._encoder, self._counters):
            message.header.frame_id = name
        self._force = node.create_publisher(WrenchStamped, f"{name}/force", RELIABLE)
        self._deflection = node.create_publisher(JointState, f"{name}/encoder", RELIABLE)
        self._captured = node.create_publisher(CaptureCounters, f"{name}/capture_counters", RELIABLE)
        self._batch: list[tuple[Time, int]] = []

    @property
    def publishers(self) -> list[Publisher]:
        """To destroy them."""
        return [self._force, self._deflection, self._captured]

    def publish(self, sample: Sample) -> None:
        """Send one sample now; its number goes with the next batch."""
        stamp = _time(sample.stamp_ns)
        self._wrench.header.stamp = self._encoder.header.stamp = stamp
        self._wrench.wrench.force.x = sample.force
        self._encoder.position[0] = sample.deflection
        self._force.publish(self._wrench)
        self._deflection.publish(self._encoder)
        self._batch.append((stamp, sample.number))

    def flush(self) -> None:
        """Send the numbers collected since the last time."""
        batch, self._batch = self._batch, []
        if batch:
            stamps, numbers = zip(*batch, strict=True)
            self._counters.header.stamp = stamps[-1]
            self._counters.stamp = list(stamps)
            self._counters.counter = array("Q", numbers)
            self._captured.publish(self._counters)


class RigTopics:
    """Angle and torque of the joint, positions of the motors."""

    def __init__(self, node: Node, motors: list[str]) -> None:
        self._angle = JointState(name=["joint"], position=[0.0])
        self._torque = WrenchStamped()
        self._torque.header.frame_id = "joint"
        self._motor = JointState(name=motors, position=[0.0] * len(motors))
        self._angles = node.create_publisher(JointState, "joint_states", RELIABLE)
        self._torques = node.create_publisher(WrenchStamped, "external_torque", RELIABLE)
        self._motors = node.create_publisher(JointState, "motor_states", RELIABLE)

    @property
    def publishers(self) -> list[Publisher]:
        """To destroy them."""
        return [self._angles, self._torques, self._motors]

    def publish_joint(self, sample: JointSample) -> None:
        """Send what is measured of the joint; the torque is about z."""
        stamp = _time(sample.stamp_ns)
        if sample.angle is not None:
            self._angle.header.stamp = stamp
            self._angle.position[0] = sample.angle
            self._angles.publish(self._angle)
        if sample.torque is not None:
            self._torque.header.stamp = stamp
            self._torque.wrench.torque.z = sample.torque
            self._torques.publish(self._torque)

    def publish_motors(self, sample: MotorSample) -> None:
        """Send the motor positions."""
        self._motor.header.stamp = _time(sample.stamp_ns)
        self._motor.position[:] = array("d", sample.positions)
        self._motors.publish(self._motor)


def _time(stamp_ns: int) -> Time:
    seconds, nanoseconds = divmod(stamp_ns, NANOSECONDS)
    return Time(sec=seconds, nanosec=nanoseconds)
