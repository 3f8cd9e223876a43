# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The estimator under clocks that jump, stand still, or are not there yet."""

import os
import signal
import subprocess
import sys
import time

import pytest
import rclpy
from geometry_msgs.msg import WrenchStamped
from rclpy.executors import SingleThreadedExecutor
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from vsa_common.ros.node import RELIABLE
from vsa_common.stamps import nanoseconds, set_stamp
from vsa_msgs.msg import TransmissionImpedance

pytestmark = pytest.mark.live

DOMAIN = 20 + (os.getpid() + 60) % 80
MAIN = "import sys; sys.argv[0] = 'estimator'; from vsa_estimator.node import main; sys.exit(main())"
HOUR = 3600 * 10**9
# Stands between the process and the C library: the wall clock, and no other, is off by the seconds in a file.
SHIM = r"""
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
extern "C" int clock_gettime(clockid_t id, struct timespec *now) noexcept {
  using Function = int (*)(clockid_t, struct timespec *);
  static Function real = (Function)dlsym(RTLD_NEXT, "clock_gettime");
  int result = real(id, now);
  if (id == CLOCK_REALTIME)
    if (FILE *file = fopen(getenv("VSA_WALL_CLOCK"), "r")) {
      long seconds = 0;
      if (fscanf(file, "%ld", &seconds) == 1) now->tv_sec += seconds;
      fclose(file);
    }
  return result;
}
"""


class Harness:
    """One estimator, a source of samples, and a subscriber."""

    def __init__(self, *arguments, **environment):
        everything = os.environ | {"ROS_DOMAIN_ID": str(DOMAIN), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        command = [sys.executable, "-c", MAIN, "--ros-args", *arguments]
        self.process = subprocess.Popen(command, env=everything | environment, stderr=subprocess.PIPE, text=True)
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=DOMAIN)
        self.node = rclpy.create_node("lab", namespace="vsa", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.force = self.node.create_publisher(WrenchStamped, "transmission_1/force", RELIABLE)
        self.encoder = self.node.create_publisher(JointState, "transmission_1/encoder", RELIABLE)
        self.clock = self.node.create_publisher(Clock, "/clock", 10)
        self.received = []
        self.node.create_subscription(
            TransmissionImpedance,
            "transmission_1/impedance",
            self.receive,
            RELIABLE,
        )
        self.until(lambda: self.node.count_subscribers("/vsa/transmission_1/encoder") > 0)
        self.until(lambda: self.node.count_publishers("/vsa/transmission_1/impedance") > 0)
        self.spin(0.3)

    def receive(self, message):
        self.received.append((time.monotonic(), message))

    def spin(self, seconds):
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self.executor.spin_once(timeout_sec=left)

    def until(self, true, seconds=90.0):
        end = time.monotonic() + seconds
        while not true():
            assert time.monotonic() < end, "timeout"
            self.executor.spin_once(timeout_sec=0.01)

    def feed(self, stamp_ns, samples, publish_clock=False):
        """Samples at 100 Hz from `stamp_ns` on; the stamp after the last."""
        for k in range(samples):
            wrench, joint = WrenchStamped(), JointState(name=["transmission_1"], position=[0.01 + 1e-5 * (k % 3)])
            wrench.wrench.force.x = 27.0 + 0.001 * k
            for message in (wrench, joint):
                set_stamp(message.header.stamp, stamp_ns)
            if publish_clock:
                time_message = Clock()
                set_stamp(time_message.clock, stamp_ns)
                self.clock.publish(time_message)
                self.spin(0.002)
            self.force.publish(wrench)
            self.encoder.publish(joint)
            self.spin(0.01)
            stamp_ns += 10_000_000
        return stamp_ns

    def close(self):
        self.process.send_signal(signal.SIGTERM)
        _, errors = self.process.communicate(timeout=10)
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)
        assert "Traceback" not in errors
        assert self.process.returncode == 0


@pytest.fixture
def simulated():
    lab = Harness("-p", "use_sim_time:=true")
    yield lab
    lab.close()


@pytest.fixture
def stepped(tmp_path):
    source, library, offset = tmp_path / "shim.cpp", tmp_path / "shim.so", tmp_path / "offset"
    source.write_text(SHIM)
    subprocess.run(["g++", "-shared", "-fPIC", "-o", library, source, "-ldl"], check=True)
    offset.write_text("0")
    lab = Harness(LD_PRELOAD=str(library), VSA_WALL_CLOCK=str(offset))
    yield lab, offset
    lab.close()


def test_without_a_clock_there_is_no_output_and_a_stopped_clock_makes_nothing_stale(simulated):
    lab = simulated
    lab.feed(100 * 10**9, 10)
    assert lab.received == []
    stamp_ns = lab.feed(100 * 10**9, 30, publish_clock=True)
    lab.until(lambda: lab.received and nanoseconds(lab.received[-1][1].header.stamp) == stamp_ns - 10_000_000)
    count = len(lab.received)
    lab.spin(0.5)
    assert len(lab.received) == count
    lab.feed(stamp_ns, 20, publish_clock=True)
    assert len(lab.received) >= count + 15
    assert all(message.status != TransmissionImpedance.STATUS_STALE for _, message in lab.received)


def test_a_wall_clock_set_back_an_hour_does_not_affect_the_watchdogs(stepped):
    lab, offset = stepped
    lab.feed(time.time_ns(), 50)
    lab.until(lambda: lab.received)
    resets = lab.received[-1][1].reset_count
    offset.write_text("-3600")
    lab.received.clear()
    lab.feed(time.time_ns() - HOUR, 50)
    silent = time.monotonic()
    lab.until(lambda: lab.received[-1][1].status == TransmissionImpedance.STATUS_STALE)
    lab.until(lambda: not lab.received[-1][1].deflection_valid)
    assert lab.received[-1][0] - silent < 0.1 + 0.2  # 0.2 s for a busy machine
    assert (lab.received[-1][1].reset_count, lab.received[-1][1].reset_reason) == (
        resets + 1,
        TransmissionImpedance.RESET_TIME_JUMP,
    )
    offset.write_text("0")
    lab.received.clear()
    lab.feed(time.time_ns(), 20)
    assert lab.received[-1][1].status != TransmissionImpedance.STATUS_STALE
