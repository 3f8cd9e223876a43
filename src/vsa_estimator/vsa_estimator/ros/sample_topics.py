# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Samples of one transmission from the topics of its force, its encoder and their sequence numbers."""

from collections.abc import Callable, Sequence

from geometry_msgs.msg import WrenchStamped
from rclpy.node import Node
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState
from vsa_common.ros.cdr import read_counters, read_position, read_wrench
from vsa_common.ros.node import BEST_EFFORT, RELIABLE
from vsa_common.stamps import NANOSECONDS
from vsa_estimator.preprocessing.pairing import Pairing
from vsa_estimator.settings import NodeConfig
from vsa_msgs.msg import CaptureCounters


class SampleTopics:
    """Pairs of force and deflection with the same stamp, and the sequence numbers of samples."""

    def __init__(
        self,
        config: NodeConfig,
        refuse: Callable[[int, str], bool],
        process: Callable[[int, float, float], None],
        count: Callable[[Sequence[int], Sequence[int]], None],
    ) -> None:
        """`refuse` checks the stamp [ns] of a sensor's message; `process` and `count` are those of EstimatorNode."""
        self._config = config
        self._refuse, self._process, self._count = refuse, process, count
        self._pairing = Pairing(*_windows(config))

    def subscribe(self, node: Node) -> list[Subscription]:
        """Subscribe `node` to the topics: to the sequence numbers where no sample is lost after they are given."""
        name, reliable = self._config.transmission, self._config.reliability == "reliable"
        topics = [(CaptureCounters, "capture_counters", self._on_counters)] if reliable else []
        topics += [(WrenchStamped, "force", self._on_force), (JointState, "encoder", self._on_encoder)]
        qos = RELIABLE if reliable else BEST_EFFORT
        return [
            node.create_subscription(kind, f"{name}/{topic}", callback, qos, raw=True)
            for kind, topic, callback in topics
        ]

    def reconfigure(self, config: NodeConfig) -> None:
        """Apply the windows of another configuration."""
        self._pairing.set_windows(*_windows(config))

    @property
    def dropped(self) -> int:
        """Messages without a counterpart."""
        return self._pairing.dropped

    def _on_counters(self, data: bytes) -> None:
        self._count(*read_counters(data))

    def _on_force(self, data: bytes) -> None:
        stamp_ns, force = read_wrench(data)
        if self._refuse(stamp_ns, "force"):
            return
        for sample in self._pairing.add_force(stamp_ns, force):
            self._process(*sample)

    def _on_encoder(self, data: bytes) -> None:
        stamp_ns, deflection = read_position(data)
        if self._refuse(stamp_ns, "encoder"):
            return
        for sample in self._pairing.add_encoder(stamp_ns, deflection):
            self._process(*sample)


def _windows(config: NodeConfig) -> tuple[int, int]:
    """Tolerance and reorder window of the pairing [ns]."""
    return int(config.pairing_tolerance * NANOSECONDS), int(config.reorder_window * NANOSECONDS)
