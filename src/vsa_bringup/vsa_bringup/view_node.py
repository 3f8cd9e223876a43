"""The live page's ear: the suite's topics, taken in a few microseconds a message and without an executor."""

from collections.abc import Callable
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState
from vsa_bringup.view_show import Show
from vsa_common.node import STEADY
from vsa_common.stamps import nanoseconds
from vsa_estimator.recordings import decode_joint_state
from vsa_msgs.msg import CaptureCounters, EstimatorState, JointImpedance, TransmissionImpedance

DEPTH = 4000  # messages that wait while this computer is busy elsewhere
_WATCHING = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT)  # never holds a controller up
_COUNTING = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.RELIABLE)  # what is lost here is no lost frame
_NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)

Taker = Callable[[bytes, int, float], None]


class Ear:
    """Subscriptions of one joint's topics, emptied by `poll`."""

    def __init__(self, namespace: str) -> None:
        self.show = Show(
            TransmissionImpedance.get_fields_and_field_types(), JointImpedance.get_fields_and_field_types()
        )
        self._node = Node("view", namespace=namespace)
        self._takers: list[tuple[Any, Taker]] = []
        joint, show = self.show.joint, self.show
        self._listen(JointImpedance, "joint_impedance", joint.take_impedance)
        self._listen(JointState, "joint_states", self._take_angle, _NEWEST)
        self._listen(DiagnosticArray, "/diagnostics", lambda data, *_: show.take_diagnostics(_diagnostics(data)))
        for name in show.sides:
            self._listen_to_side(name)

    @property
    def namespace(self) -> str:
        """Where the topics are."""
        return self._node.get_namespace()

    def poll(self) -> int:
        """Take everything that has arrived; returns how many messages that was."""
        count = 0
        now = 1e-9 * STEADY.now().nanoseconds
        for subscription, take in self._takers:
            with subscription.handle:
                while (found := subscription.handle.take_message(subscription.msg_type, True)) is not None:
                    take(found[0], found[1]["received_timestamp"], now)
                    count += 1
        return count

    def words(self) -> dict[str, Any]:
        """As Show.words, now."""
        joint = self.show.joint
        if joint.last:
            joint.reason = deserialize_message(joint.last, JointImpedance).reason
        return self.show.words(1e-9 * STEADY.now().nanoseconds)

    def close(self) -> None:
        """Stop listening."""
        self._node.destroy_node()

    def _listen_to_side(self, name: str) -> None:
        side = self.show.sides[name]

        def take_state(data: bytes, *_: object) -> None:
            message = deserialize_message(data, EstimatorState)
            side.take_state(message, nanoseconds(message.header.stamp))

        def take_encoder(data: bytes, *_: object) -> None:
            stamp_ns, position = decode_joint_state(data)
            side.encoder.add(stamp_ns, (position,))

        self._listen(TransmissionImpedance, f"{name}/impedance", lambda data, _, now: side.take_impedance(data, now))
        self._listen(EstimatorState, f"{name}/estimator_state", take_state)
        self._listen(JointState, f"{name}/encoder", take_encoder)
        counters = f"{name}/capture_counters"
        self._listen(CaptureCounters, counters, lambda data, *_: side.take_counters(_counters(data)), _COUNTING)

    def _listen(self, kind: Any, topic: str, take: Any, qos: QoSProfile = _WATCHING) -> None:
        self._takers.append((self._node.create_subscription(kind, topic, print, qos, raw=True), take))

    def _take_angle(self, data: bytes, *_: object) -> None:
        self.show.joint.angle = decode_joint_state(data)[1]


def _diagnostics(data: bytes) -> DiagnosticArray:
    return deserialize_message(data, DiagnosticArray)


def _counters(data: bytes) -> CaptureCounters:
    return deserialize_message(data, CaptureCounters)
