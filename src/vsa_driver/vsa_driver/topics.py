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
from vsa_driver.message_template import Prepared
from vsa_msgs.msg import CaptureCounters

_MARKS = (1.5e-200, 2.5e-200)  # stand where a prepared message is filled


class TransmissionTopics:
    """Force and encoder of one transmission, with one stamp, and which frame each came from."""

    def __init__(self, node: Node, name: str) -> None:
        self._name = name
        self._wrench = _torsor(name, force=Vector3(x=_MARKS[0]))
        self._position = _positions(name, [name])
        self._force = node.create_publisher(WrenchStamped, f"{name}/force", RELIABLE)
        self._encoder = node.create_publisher(JointState, f"{name}/encoder", RELIABLE)
        self._captured = node.create_publisher(CaptureCounters, f"{name}/capture_counters", RELIABLE)
        self._batch: list[Measurement] = []

    @property
    def publishers(self) -> list[Publisher]:
        """To destroy them."""
        return [self._force, self._encoder, self._captured]

    def publish(self, sample: Measurement) -> None:
        """Send one sample now; its number goes with the next batch."""
        self._force.publish(self._wrench.fill(sample.stamp_ns, sample.force))
        self._encoder.publish(self._position.fill(sample.stamp_ns, sample.deflection))
        self._batch.append(sample)

    def flush(self) -> None:
        """Send the numbers collected since the last time."""
        batch, self._batch = self._batch, []
        if batch:
            stamps, numbers = [sample.stamp_ns for sample in batch], [sample.number for sample in batch]
            self._captured.publish(write_counters(self._name, stamps, numbers))


class RigTopics:
    """Angle and torque of the joint, positions of the motors."""

    def __init__(self, node: Node, motors: list[str]) -> None:
        self._angle = _positions("joint", ["joint"])
        self._torque = _torsor("joint", torque=Vector3(z=_MARKS[0]))
        self._motor = _positions("motors", motors)
        self._angles = ThrottledPublisher(node, JointState, "joint_states")
        self._torques = node.create_publisher(WrenchStamped, "external_torque", RELIABLE)
        self._motors = node.create_publisher(JointState, "motor_states", RELIABLE)

    @property
    def publishers(self) -> list[Publisher]:
        """To destroy them."""
        return [*self._angles.publishers, self._torques, self._motors]

    def publish_joint(self, sample: JointSample) -> None:
        """Send what is measured of the joint; the torque is about z."""
        if sample.angle is not None:
            self._angles.publish(sample.stamp_ns, self._angle.fill(sample.stamp_ns, sample.angle))
        if sample.torque is not None:
            self._torques.publish(self._torque.fill(sample.stamp_ns, sample.torque))

    def publish_motors(self, sample: MotorSample) -> None:
        """Send the motor positions."""
        self._motors.publish(self._motor.fill(sample.stamp_ns, *sample.positions))


def _positions(frame: str, names: list[str]) -> Prepared:
    marks = list(_MARKS[: len(names)])
    return Prepared(JointState(header=Header(frame_id=frame), name=names, position=marks), marks)


def _torsor(frame: str, **part: Vector3) -> Prepared:
    return Prepared(WrenchStamped(header=Header(frame_id=frame), wrench=Wrench(**part)), _MARKS[:1])
