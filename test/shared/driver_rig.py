# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The rig's side of a driver under test: its process, CAN frames on a multicast socket, a real ROS 2 subscriber."""

import contextlib
import os
import struct
import subprocess
import sys
import time
from types import SimpleNamespace

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from rclpy.experimental import EventsExecutor
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger
from vsa_common.ros.node import RELIABLE
from vsa_driver.can.bus import BusConfig, MalformedFrame, open_bus
from vsa_msgs.msg import CaptureCounters

DOMAIN = 20 + os.getpid() % 80
PORT = 42000 + os.getpid() % 1000
BUS = BusConfig(channel="239.74.163.88", options=("hop_limit=0", f"port={PORT}"))
OPTIONS = f"bus.options:=['{BUS.options[0]}','{BUS.options[1]}']"
TOPICS = {
    "transmission_1/force": WrenchStamped,
    "transmission_1/encoder": JointState,
    "transmission_1/capture_counters": CaptureCounters,
    "transmission_2/force": WrenchStamped,
    "transmission_2/encoder": JointState,
    "joint_states": JointState,
    "joint_states_throttle": JointState,
    "external_torque": WrenchStamped,
    "motor_states": JointState,
}


def start_driver(*parameters):
    arguments = [word for parameter in parameters for word in ("-p", parameter)]
    environment = os.environ | {"ROS_DOMAIN_ID": str(DOMAIN), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    return subprocess.Popen(
        [sys.executable, "-m", "vsa_driver.node", "--ros-args", *arguments],
        env=environment, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def signed(value, step):
    return round(value / step).to_bytes(3, "little", signed=True)


class Rig:
    """The rig's side of the bus and a subscriber to all topics of the driver."""

    def __init__(self):
        self.bus = open_bus(BUS)
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=DOMAIN)
        self.node = rclpy.create_node("rig", namespace="vsa", context=self.context)
        self.executor = EventsExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.received = {topic: [] for topic in TOPICS}
        self.reports = []
        self.sequence = -1
        for topic, kind in TOPICS.items():
            self.node.create_subscription(kind, topic, self.received[topic].append, RELIABLE)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self.on_diagnostics, 10)
        self.commands = self.node.create_publisher(JointState, "motor_commands", RELIABLE)
        self.arm = self.node.create_client(SetBool, "driver/arm")
        self.tare = self.node.create_client(Trigger, "driver/tare")

    def on_diagnostics(self, message):
        """Tasks of the driver with the level of the worst one, as `reports`."""
        own = {status.name.partition(": ")[2]: status for status in message.status if "/driver: " in status.name}
        if own:
            self.reports.append(SimpleNamespace(level=max(status.level for status in own.values()), tasks=own))

    def sample(self, force=20.0, count=500, motors=(0.5, -0.25)):
        """One sample of the rig: four frames."""
        self.sequence += 1
        counter = struct.pack("<H", self.sequence % 65536)
        for i in (1, 2):
            self.bus.send(0x100 + i, signed(force * i, 1e-4) + struct.pack("<H", count + i) + counter)
        self.bus.send(0x110, signed(0.125, 1e-6) + signed(-0.75, 1e-5) + counter)
        self.bus.send(0x120, signed(motors[0], 1e-5) + signed(motors[1], 1e-5) + b"\0" + counter[:1])

    def until(self, condition, send=True, timeout=10.0):
        """Serve the subscriptions until `condition`, sending samples at 200 Hz of the device's clock."""
        due = time.monotonic()
        end = due + timeout
        while not condition():
            assert time.monotonic() < end, f"timeout; the last report: {self.reports[-1:]}"
            self.serve(0.005)
            while send and due <= time.monotonic():
                self.sample()
                due += 0.005

    def serve(self, seconds):
        """Serve the subscriptions for `seconds`."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self.executor.spin_once(timeout_sec=left)

    def call(self, client, request):
        future = client.call_async(request)
        self.until(future.done)
        return future.result()

    def sent_commands(self):
        """Positions of the command frames on the bus so far."""
        return [
            tuple(int.from_bytes(frame.data[i : i + 3], "little", signed=True) * 1e-5 for i in (0, 3))
            for frame in iter(self.receive, None)
            if frame.arbitration_id == 0x200
        ]

    def receive(self):
        """The next frame on the bus; None where none is waiting."""
        while True:
            with contextlib.suppress(MalformedFrame):
                return self.bus.receive(0.0)

    def command(self, *positions):
        self.commands.publish(JointState(name=["motor_1", "motor_2"], position=list(positions)))

    def count(self, name):
        """Value of a counter, "task.name", in the newest report."""
        task, _, key = name.partition(".")
        return int(next(value.value for value in self.reports[-1].tasks[task].values if value.key == key))

    def close(self):
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)
        self.bus.close()
