# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The only module that imports python-can: open a bus from parameters, send and receive frames.

Every interface of python-can is supported: `socketcan` on a robot, `udp_multicast` between processes of one machine
without CAN hardware, `virtual` inside one process.
"""

import contextlib
import errno
import importlib
import inspect
import logging
import os
import select
import socket
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import can
from can.interfaces.udp_multicast import UdpMulticastBus
from can.interfaces.udp_multicast.bus import SO_TIMESTAMPNS, GeneralPurposeUdpMulticastBus
from can.interfaces.udp_multicast.utils import pack_message
from vsa_common.config.configuration import quantity, string
from vsa_driver.can.socket_filter import drop_datagrams

Frame = can.Message

logging.getLogger("can").setLevel(logging.ERROR)  # a bus that failed to open warns again when it is collected

_ID_FIELD = b"arbitration_id\xcd"  # as msgpack writes it before an identifier of two bytes

IP_MULTICAST_ALL = 49  # <linux/in.h>; the socket module lacks the name


class BusError(OSError):
    """The bus cannot be opened, or failed in operation; the text names interface, channel and reason."""


class MalformedFrame(ValueError):
    """A datagram arrived that is no CAN frame; the bus itself works."""


@dataclass(frozen=True)
class BusConfig:
    """CAN bus to open, in python-can's terms."""

    interface: str = string("udp_multicast", "python-can interface: socketcan, udp_multicast, virtual, pcan, ...")
    channel: str = string("239.74.163.2", "channel of the interface: can0, a multicast address, a name")
    bitrate: int = quantity(1_000_000, "bit/s", 10_000, 8_000_000, "bit rate, for interfaces that set one")
    options: tuple[str, ...] = string(("hop_limit=0",), "further arguments of the interface, each key=value")
    receive_buffer: int = quantity(4_000_000, "byte", 0, 1_000_000_000, "socket receive buffer asked for; 0 leaves it")


class Bus:
    """An open CAN bus. Close it, or use it in a `with` statement."""

    def __init__(self, bus: can.BusABC, name: str) -> None:
        self._bus = bus
        self.name = name
        self._datagrams: select.poll | None = None
        if isinstance(bus, UdpMulticastBus):
            self._datagrams = select.poll()
            self._datagrams.register(bus.fileno(), select.POLLIN)

    def send(
        self, arbitration_id: int, data: bytes, extended: bool = False, fd: bool = False, error: bool = False
    ) -> None:
        """Send one frame, or an error frame where an interface can. Raises BusError where the bus rejects it."""
        frame = can.Message(
            arbitration_id=arbitration_id, data=data, is_extended_id=extended, is_fd=fd, is_error_frame=error
        )
        try:
            self._bus.send(frame)
        except (can.CanError, OSError, ValueError) as error:
            raise BusError(f"{self.name}: {_reason(error)}") from error

    def receive(self, timeout: float | None = 0.0) -> Frame | None:
        """Next frame with its capture time `timestamp` [s], or None after `timeout` [s]; None waits without limit.

        Raises BusError when the bus failed, MalformedFrame for a datagram that is no frame.
        """
        if timeout == 0.0 and self._datagrams is not None and not self._datagrams.poll(0):
            return None  # takes a tenth of the time of python-can's recv
        try:
            return self._bus.recv(timeout)
        except (can.CanError, OSError, ValueError) as error:  # ValueError: the descriptor was closed
            if isinstance(error, can.CanError) and not isinstance(error.__cause__, OSError | None):
                raise MalformedFrame(f"{self.name}: {_reason(error)}") from error
            raise BusError(f"{self.name}: {_reason(error)}") from error

    def ignore(self, arbitration_ids: Iterable[int]) -> None:
        """Let the kernel drop standard frames of these identifiers where it supports that; elsewhere they arrive.

        A multicast socket receives what it sends.
        """
        if isinstance(self._bus, UdpMulticastBus):
            head, field, _ = pack_message(can.Message(arbitration_id=0x7FF, is_extended_id=False)).partition(_ID_FIELD)
            if field:
                with contextlib.suppress(OSError):
                    drop_datagrams(self.fileno(), len(head + field) - 1, _ID_FIELD[-1], tuple(arbitration_ids))

    def fileno(self) -> int:
        """File descriptor to wait on, -1 where the interface has none."""
        try:
            return self._bus.fileno()
        except NotImplementedError:
            return -1

    def close(self) -> None:
        """Close the bus; closing twice is no error."""
        self._bus.shutdown()

    def __enter__(self) -> "Bus":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def open_bus(config: BusConfig) -> Bus:
    """Open the bus that `config` describes. Raises BusError with the reason on one line."""
    name = f"CAN bus {config.interface} {config.channel}"
    options: dict[str, Any] = {"bitrate": config.bitrate} | parse_options(config.options)
    try:
        _check_options(config.interface, options, name)
        bus = _open(config.interface, config.channel, options)
    except (can.CanError, NotImplementedError, ImportError, OSError, ValueError, TypeError) as error:
        raise BusError(f"cannot open {name}: {_reason(error)}") from error
    opened = Bus(bus, name)
    _tune_socket(opened.fileno(), config)
    return opened


def _open(interface: str, channel: str, options: dict[str, Any]) -> can.BusABC:
    try:
        return can.Bus(interface=interface, channel=channel, ignore_config=True, **options)
    except can.CanInitializationError as error:
        unrouted = isinstance(error.__cause__, OSError) and error.__cause__.errno == errno.ENODEV
        if interface != "udp_multicast" or options.get("hop_limit") != 0 or not unrouted:
            raise
        return _LoopbackBus(channel, **options)


class _LoopbackSocket(GeneralPurposeUdpMulticastBus):
    """Joins on the loopback interface by its address; python-can needs a route, and the routing table may be empty."""

    def _create_socket(self, address_family: socket.AddressFamily) -> socket.socket:
        loopback = socket.inet_aton("127.0.0.1")
        handle = socket.socket(address_family, socket.SOCK_DGRAM)
        for option in (socket.SO_REUSEADDR, socket.SO_REUSEPORT, SO_TIMESTAMPNS):
            handle.setsockopt(socket.SOL_SOCKET, option, 1)
        self.timestamp_nanosecond = True
        handle.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, loopback)
        handle.bind(("", self.port))
        handle.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(self.group) + loopback)
        return handle


class _LoopbackBus(UdpMulticastBus):
    """udp_multicast within a machine without network."""

    def __init__(self, channel: str, port: int = 43113, fd: bool = True, **_: Any) -> None:
        can.BusABC.__init__(self, channel)
        self._multicast = _LoopbackSocket(channel, port, 0)
        self._can_protocol = can.CanProtocol.CAN_FD if fd else can.CanProtocol.CAN_20


def parse_options(options: tuple[str, ...]) -> dict[str, bool | int | float | str]:
    """Arguments from texts, each as bool, int, float or text. Raises BusError for one without `=`.

    >>> parse_options(("hop_limit=0", "fd=true", "port=0x400", "serial=AB1"))
    {'hop_limit': 0, 'fd': True, 'port': 1024, 'serial': 'AB1'}
    """
    parsed = {}
    for option in filter(None, options):  # a parameter file writes an empty list as ['']
        key, equals, value = option.partition("=")
        if not equals or not key.strip().isidentifier():
            raise BusError(f"CAN bus option {option!r}: expected key=value")
        parsed[key.strip()] = _typed(value.strip())
    return parsed


def _typed(text: str) -> bool | int | float | str:
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    for kind in (lambda word: int(word, 0), float):
        with contextlib.suppress(ValueError):
            return kind(text)
    return text


def _check_options(interface: str, options: dict[str, Any], name: str) -> None:
    # python-can ignores unknown arguments; a misspelt hop_limit would let frames leave the host
    if interface not in can.interfaces.BACKENDS:
        raise BusError(f"no such interface; python-can has {', '.join(sorted(can.interfaces.BACKENDS))}")
    module, class_name = can.interfaces.BACKENDS[interface]
    accepted = {"bitrate"}
    for ancestor in getattr(importlib.import_module(module), class_name).__mro__[:-1]:
        accepted |= set(inspect.signature(ancestor.__init__).parameters)
    for key in options:
        if key not in accepted:
            raise BusError(f"the interface has no option {key!r}")


def _tune_socket(descriptor: int, config: BusConfig) -> None:
    if descriptor < 0:
        return
    duplicate = os.dup(descriptor)
    try:
        handle = socket.socket(fileno=duplicate)
    except OSError:  # a serial line or a character device has no socket options
        os.close(duplicate)
        return
    with handle:
        if config.receive_buffer:
            handle.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, config.receive_buffer)
        if config.interface == "udp_multicast" and handle.family == socket.AF_INET:
            # by default Linux delivers every group that any process of the host joined, not only the socket's own
            with contextlib.suppress(OSError):
                handle.setsockopt(socket.IPPROTO_IP, IP_MULTICAST_ALL, 0)


def _reason(error: BaseException) -> str:
    reason = str(error)
    if error.__cause__ is not None and str(error.__cause__) not in reason:
        reason += f" ({error.__cause__})"
    return " ".join(reason.split()) or type(error).__name__
