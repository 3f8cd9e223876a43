# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The thread that reads the bus, on python-can's own virtual bus and on one that fails as hardware does."""

import queue
import threading
import time
from contextlib import contextmanager
from itertools import pairwise

import pytest
from vsa_common.ros import idle as rest
from vsa_driver.can.bus import BusConfig, BusError, Frame, open_bus
from vsa_driver.can.link import BusLink

pytestmark = pytest.mark.live

VIRTUAL = BusConfig(interface="virtual", channel="test_link", options=())


class FailingOpener:
    """Opens the virtual bus; the next `failures` attempts fail."""

    def __init__(self):
        self.failures = 0
        self.opened = []
        self.times = []

    def __call__(self, config):
        self.times.append(time.monotonic())
        if self.failures:
            self.failures -= 1
            raise BusError("interface is down")
        self.opened.append(open_bus(config))
        return self.opened[-1]


@pytest.fixture
def opener():
    return FailingOpener()


@pytest.fixture
def frames():
    return queue.Queue()


@pytest.fixture
def downs():
    return queue.Queue()


@contextmanager
def opened(opener, frames, downs):
    link = BusLink(VIRTUAL, frames.put, downs.put, opener)
    link.open()
    try:
        yield link
    finally:
        link.close()


@pytest.fixture
def link(opener, frames, downs):
    with opened(opener, frames, downs) as link:
        yield link


def until(true, timeout=5.0):
    end = time.monotonic() + timeout
    while not true():
        assert time.monotonic() < end
        threading.Event().wait(0.002)


def test_every_frame_arrives_in_order(link, frames):
    with open_bus(VIRTUAL) as sender:
        for i in range(500):
            sender.send(0x101, i.to_bytes(2, "little"))
        assert [int.from_bytes(frames.get(timeout=5).data, "little") for _ in range(500)] == list(range(500))


def test_a_busy_thread_reads_frames_in_batches_and_in_order(opener, downs, monkeypatch):
    monkeypatch.setattr(rest, "BUSY", -1.0)
    monkeypatch.setattr(rest, "WINDOW_S", 0.0)
    taken = []
    link = BusLink(VIRTUAL, lambda frame: taken.append((time.monotonic(), frame)), downs.put, opener, coalescing_s=0.05)
    link.open()
    with open_bus(VIRTUAL) as sender:
        for i in range(200):
            sender.send(0x101, i.to_bytes(2, "little"))
        until(lambda: len(taken) == 200)
    link.close()
    assert [int.from_bytes(frame.data, "little") for _, frame in taken] == list(range(200))
    gaps = [after - before for (before, _), (after, _) in pairwise(taken)]
    assert sum(gap > 0.03 for gap in gaps) < 20  # of 200: the others arrived in batches


def test_a_sent_frame_reaches_the_bus(link):
    with open_bus(VIRTUAL) as listener:
        link.send(0x200, b"\x01\x02", extended=False, fd=False)
        assert bytes(listener.receive(1.0).data) == b"\x01\x02"


def test_a_failed_bus_is_reported_within_a_second_and_reopened_with_growing_waits():
    opener, frames, downs = FailingOpener(), queue.Queue(), queue.Queue()
    with opened(opener, frames, downs) as link:
        opener.failures = 3
        since = time.monotonic()
        opener.opened[0]._bus.shutdown()
        assert downs.get(timeout=1.0)
        with pytest.raises(BusError, match=r"CAN bus virtual|interface is down"):
            link.send(0x200, b"", extended=False, fd=False)
        until(lambda: link.up)
        tries = [moment - since for moment in opener.times if moment > since]
        waits = [after - before for before, after in pairwise(tries)]
        assert len(tries) == 4
        assert all(after > 1.5 * before for before, after in pairwise(waits))
        assert (link.failures, link.reopened, link.reason) == (1, 1, "")
        with open_bus(VIRTUAL) as sender:
            sender.send(0x101, b"\x07")
            assert bytes(frames.get(timeout=1.0).data) == b"\x07"


def test_a_bus_off_error_frame_closes_and_reopens_the_bus(link, downs):
    with open_bus(VIRTUAL) as sender:
        sender._bus.send(Frame(arbitration_id=0x40, is_extended_id=False, is_error_frame=True, dlc=8, data=bytes(8)))
        assert "bus-off" in downs.get(timeout=1.0)
    until(lambda: link.reopened == 1)


def test_a_bus_that_fails_to_open_at_start_raises(opener):
    opener.failures = 1
    with pytest.raises(BusError, match="interface is down"):
        BusLink(VIRTUAL, print, print, opener).open()


def test_closing_stops_the_thread_also_while_the_bus_is_down(opener):
    link = BusLink(VIRTUAL, print, lambda _: None, opener)
    link.open()
    opener.failures = 10**9
    opener.opened[0]._bus.shutdown()
    until(lambda: not link.up)
    before = threading.active_count()
    link.close()
    assert threading.active_count() == before - 1
