# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The CAN bus, over a real multicast socket and python-can's virtual bus."""

import os
import socket
import struct
import subprocess
import sys
from types import SimpleNamespace

import pytest
from vsa_driver.can.bus import BusConfig, BusError, MalformedFrame, open_bus, parse_options

CHANNEL, PORT = "239.74.163.77", 43877
MULTICAST = BusConfig(channel=CHANNEL, options=("hop_limit=0", f"port={PORT}"))


def test_a_frame_crosses_the_multicast_bus_with_its_capture_time():
    with open_bus(MULTICAST) as sender, open_bus(MULTICAST) as receiver:
        sender.send(0x101, bytes(range(7)))
        frame = receiver.receive(1.0)
    assert (frame.arbitration_id, bytes(frame.data), frame.is_extended_id) == (0x101, bytes(range(7)), False)
    assert frame.timestamp > 1.6e9


def test_a_frame_crosses_the_virtual_bus():
    config = BusConfig(interface="virtual", channel="test_bus", options=())
    with open_bus(config) as sender, open_bus(config) as receiver:
        sender.send(0x18FF0102, b"\x01", extended=True)
        frame = receiver.receive(1.0)
        assert receiver.receive() is None
        assert receiver.fileno() == -1
    assert (frame.arbitration_id, bytes(frame.data), frame.is_extended_id) == (0x18FF0102, b"\x01", True)


def test_another_group_on_the_same_port_is_not_received():
    elsewhere = BusConfig(channel="239.74.163.78", options=("hop_limit=0", f"port={PORT}"))
    with open_bus(MULTICAST) as sender, open_bus(elsewhere) as other, open_bus(MULTICAST) as receiver:
        sender.send(0x101, b"\x01")
        assert receiver.receive(1.0) is not None
        assert other.receive(0.0) is None


def test_ignored_identifiers_are_dropped_by_the_kernel_and_all_others_arrive():
    with open_bus(MULTICAST) as sender, open_bus(MULTICAST) as receiver:
        receiver.ignore((0x101, 0x102, 0x720))
        for identifier in (0x101, 0x100, 0x102, 0x720, 0x20, 0x200, 0x7FF):
            sender.send(identifier, b"\x01")
        sender.send(0x18FF0102, b"\x01", extended=True)
        received = [receiver.receive(1.0).arbitration_id for _ in range(5)]
        assert receiver.receive(0.0) is None
    assert received == [0x100, 0x20, 0x200, 0x7FF, 0x18FF0102]


def test_the_multicast_bus_works_on_a_machine_without_network():
    script = (
        "from vsa_driver.can.bus import BusConfig, open_bus\n"
        "with open_bus(BusConfig()) as sender, open_bus(BusConfig()) as receiver:\n"
        "    sender.send(0x101, b'abc')\n"
        "    frame = receiver.receive(2.0)\n"
        "    print(hex(frame.arbitration_id), bytes(frame.data), frame.timestamp > 1.6e9)\n"
    )
    isolated = ["unshare", "--map-root-user", "--net", "sh", "-c", 'ip link set lo up && exec "$0" -c "$1"']
    if subprocess.run([*isolated[:3], "true"], capture_output=True, check=False).returncode:
        pytest.skip("network namespaces are not permitted here")
    run = subprocess.run([*isolated, sys.executable, script], capture_output=True, text=True, check=False)
    assert (run.stdout.strip(), run.stderr) == ("0x101 b'abc' True", "")


def test_a_datagram_that_is_no_frame_is_distinguished_from_a_bus_failure():
    with open_bus(MULTICAST) as receiver, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other_sender:
        other_sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, struct.pack("@I", 0))
        other_sender.sendto(b"hello", (CHANNEL, PORT))
        with pytest.raises(MalformedFrame):
            receiver.receive(1.0)


def test_a_bus_whose_descriptor_is_no_socket_leaves_no_other_descriptor_open(monkeypatch):
    line, other_end = os.pipe()  # a descriptor without socket options, as of a serial line
    monkeypatch.setattr("can.Bus", lambda **_: SimpleNamespace(fileno=lambda: line))
    before = os.listdir("/proc/self/fd")
    for _ in range(3):
        open_bus(BusConfig(interface="virtual", channel="line", options=()))
    assert os.listdir("/proc/self/fd") == before
    os.close(line)
    os.close(other_end)


def test_a_closed_bus_raises_a_bus_error():
    bus = open_bus(MULTICAST)
    bus.close()
    with pytest.raises(BusError, match=f"udp_multicast {CHANNEL}"):
        bus.receive(0.1)


@pytest.mark.parametrize(
    ("config", "reason"),
    [
        (BusConfig(interface="nonsense"), "cannot open CAN bus nonsense 239.74.163.2: no such interface"),
        (BusConfig(interface="socketcan", channel="can_none", options=()), "cannot open CAN bus socketcan can_none: "),
        (BusConfig(channel="10.1.2.3"), "cannot open CAN bus udp_multicast 10.1.2.3: "),
        (BusConfig(options=("hop_limt=0",)), "the interface has no option 'hop_limt'"),
        (BusConfig(options=("hop_limit",)), "CAN bus option 'hop_limit': expected key=value"),
    ],
)
def test_a_bus_that_cannot_be_opened_is_an_error_of_one_line(config, reason):
    with pytest.raises(BusError) as caught:
        open_bus(config)
    assert reason in str(caught.value)
    assert "\n" not in str(caught.value)


def test_options_are_parsed_as_bool_int_float_or_text():
    options = ("fd=true", "hop_limit=0", "port=0x10", "timeout=0.5", "name=can a", "empty=")
    expected = {"fd": True, "hop_limit": 0, "port": 16, "timeout": 0.5, "name": "can a", "empty": ""}
    parsed = parse_options(options)
    assert parsed == expected
    assert [type(value) for value in parsed.values()] == [bool, int, int, float, str, str]
