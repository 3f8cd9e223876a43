# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Pauses of a busy thread: when they begin and end, and the order of the messages that they coalesce."""

import os

import pytest
import rclpy
from rclpy.experimental import EventsExecutor
from std_msgs.msg import UInt32
from vsa_common.ros import idle
from vsa_common.ros.idle import BUSY, IDLE, WINDOW_S, Coalescer
from vsa_common.ros.node import RELIABLE
from vsa_common.ros.process import Spinner

pytestmark = pytest.mark.live

DOMAIN = 20 + (os.getpid() + 5) % 80


class Clock:
    """A steady clock and the processor time of a thread that takes `share` of a core."""

    def __init__(self):
        self.now = self.cpu = 0.0

    def work(self, share, seconds, thread):
        """The thread's pause [s] after `seconds` of work."""
        for _ in range(round(seconds / WINDOW_S)):
            self.now += 1.01 * WINDOW_S
            self.cpu += 1.01 * WINDOW_S * share
            pause = thread.pause()
        return pause


@pytest.fixture
def busy():
    clock = Clock()
    thread = Coalescer(0.004, lambda: clock.now, lambda: clock.cpu)
    assert clock.work(1.5 * BUSY, 1.0, thread) == 0.004
    return clock, thread


def test_a_thread_below_the_busy_share_never_pauses():
    clock = Clock()
    assert clock.work(0.9 * BUSY, 10.0, Coalescer(0.004, lambda: clock.now, lambda: clock.cpu)) == 0.0


def test_pauses_continue_within_the_hysteresis_and_end_below_the_idle_share(busy):
    clock, thread = busy
    assert clock.work(1.1 * IDLE, 10.0, thread) == 0.004
    assert clock.work(0.9 * IDLE, 1.0, thread) == 0.0


def test_one_long_turn_causes_no_pause():
    clock = Clock()
    thread = Coalescer(0.004, lambda: clock.now, lambda: clock.cpu)
    clock.work(0.05, 1.0, thread)
    assert clock.work(1.0, WINDOW_S, thread) == 0.0


def test_a_turn_of_a_busy_thread_serves_all_queued_messages(monkeypatch):
    monkeypatch.setattr(idle, "BUSY", -1.0)
    monkeypatch.setattr(idle, "WINDOW_S", 0.0)
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=DOMAIN)
    node = rclpy.create_node("receiver", context=context)
    executor, received = EventsExecutor(context=context), []
    node.create_subscription(UInt32, "numbers", received.append, RELIABLE)
    publisher = node.create_publisher(UInt32, "numbers", RELIABLE)
    executor.add_node(node)
    turn = Spinner(0.004)
    for _ in range(300):  # until discovery has matched publisher and subscription
        publisher.publish(UInt32(data=0))
        turn(executor, [node], 0.1)
        if received:
            break
    received.clear()
    for number in range(1, 31):
        publisher.publish(UInt32(data=number))
    for _ in range(100):
        before = len(received)
        turn(executor, [node], 0.1)
        if len(received) > before + 5:
            break
    else:
        raise AssertionError("never more than a few at a time")
    for _ in range(30):
        turn(executor, [node], 0.01)
    numbers = [message.data for message in received]
    assert numbers[-30:] == list(range(1, 31))
    node.destroy_node()
    rclpy.shutdown(context=context)
