"""Rests of a busy thread: when they begin and end, and that nothing waits for them longer than it must."""

import os

import pytest
import rclpy
from rclpy.experimental import EventsExecutor
from std_msgs.msg import UInt32
from vsa_common.ros import idle as rest
from vsa_common.ros.idle import RESTED, TIRED, WINDOW_S, Coalescer
from vsa_common.ros.node import RELIABLE
from vsa_common.ros.process import Spinner

pytestmark = pytest.mark.live

DOMAIN = 20 + (os.getpid() + 5) % 80


class Clock:
    """A steady clock and the processor time of a thread that takes `share` of a core."""

    def __init__(self):
        self.now = self.cpu = 0.0

    def work(self, share, seconds, thread):
        """What the thread is told at the end of so long a time [s]."""
        for _ in range(round(seconds / WINDOW_S)):
            self.now += 1.01 * WINDOW_S
            self.cpu += 1.01 * WINDOW_S * share
            due = thread.due()
        return due


@pytest.fixture
def tired():
    clock = Clock()
    thread = Coalescer(0.004, lambda: clock.now, lambda: clock.cpu)
    assert clock.work(1.5 * TIRED, 1.0, thread) == 0.004
    return clock, thread


def test_a_thread_that_has_little_to_do_never_rests():
    clock = Clock()
    assert clock.work(0.9 * TIRED, 10.0, Coalescer(0.004, lambda: clock.now, lambda: clock.cpu)) == 0.0


def test_rests_that_help_go_on_and_end_when_there_is_little_to_do(tired):
    clock, thread = tired
    assert clock.work(1.1 * RESTED, 10.0, thread) == 0.004
    assert clock.work(0.9 * RESTED, 1.0, thread) == 0.0


def test_one_long_turn_is_no_busy_thread():
    clock = Clock()
    thread = Coalescer(0.004, lambda: clock.now, lambda: clock.cpu)
    clock.work(0.05, 1.0, thread)
    assert clock.work(1.0, WINDOW_S, thread) == 0.0


def test_a_turn_of_a_busy_thread_serves_all_that_waits(monkeypatch):
    monkeypatch.setattr(rest, "TIRED", -1.0)
    monkeypatch.setattr(rest, "WINDOW_S", 0.0)
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=DOMAIN)
    node = rclpy.create_node("mute", context=context)
    executor, heard = EventsExecutor(context=context), []
    node.create_subscription(UInt32, "numbers", heard.append, RELIABLE)
    publisher = node.create_publisher(UInt32, "numbers", RELIABLE)
    executor.add_node(node)
    turn = Spinner(0.004)
    for _ in range(300):  # until the topic has found its reader
        publisher.publish(UInt32(data=0))
        turn(executor, [node], 0.1)
        if heard:
            break
    heard.clear()
    for number in range(1, 31):
        publisher.publish(UInt32(data=number))
    for _ in range(100):
        before = len(heard)
        turn(executor, [node], 0.1)
        if len(heard) > before + 5:
            break
    else:
        raise AssertionError("never more than a few at a time")
    for _ in range(30):
        turn(executor, [node], 0.01)
    numbers = [message.data for message in heard]
    assert numbers[-30:] == list(range(1, 31))
    node.destroy_node()
    rclpy.shutdown(context=context)
