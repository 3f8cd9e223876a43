# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Two network namespaces and a link between them with delay, loss and interruption.

Each host has one end of a veth pair; a thread of this process forwards the packets between the other
ends. The kernel module netem is not available everywhere.
"""

import heapq
import itertools
import os
import random
import select
import socket
import subprocess
import sys
import threading
import time

CHECKSUMS_OFF = """
import ctypes, fcntl, socket, struct, sys
value = ctypes.create_string_buffer(struct.pack("II", 0x17, 0))  # ETHTOOL_STXCSUM: compute checksums in software
request = struct.pack("16sP", sys.argv[1].encode(), ctypes.addressof(value))
fcntl.ioctl(socket.socket(socket.AF_INET, socket.SOCK_DGRAM), 0x8946, request)
"""


def run(*words):
    subprocess.run(words, check=True, capture_output=True, text=True)


def permitted():
    """Whether network namespaces can be created."""
    name = f"vsa_try_{os.getpid()}"
    try:
        run("ip", "netns", "add", name)
        run("ip", "netns", "del", name)
    except (OSError, subprocess.CalledProcessError):
        return False
    return True


class Wire:
    """Hosts `a` and `b` at 10.77.0.1 and 10.77.0.2. The end of the `with` block removes them."""

    def __init__(self):
        self.delay, self.jitter, self.loss, self.cut = 0.0, 0.0, 0.0, False
        self.carried = self.dropped = 0
        self.hosts = [f"vsa_{side}_{os.getpid()}" for side in "ab"]
        self._ends = [f"vsa{side}{os.getpid() % 100_000}" for side in "ab"]
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._carry, daemon=True)

    def __enter__(self):
        try:
            for number, (host, end) in enumerate(zip(self.hosts, self._ends, strict=True), 1):
                run("ip", "netns", "add", host)
                run("ip", "link", "add", end, "type", "veth", "peer", "name", "wire", "netns", host)
                run("ip", "link", "set", end, "up")
                inside = ("ip", "-n", host)
                run(*inside, "link", "set", "lo", "up")
                run(*inside, "address", "add", f"10.77.0.{number}/24", "dev", "wire")
                run(*inside, "link", "set", "wire", "up")
                run(*inside, "route", "add", "224.0.0.0/4", "dev", "wire")
                run("ip", "netns", "exec", host, sys.executable, "-c", CHECKSUMS_OFF, "wire")
            self._sockets = [socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(3)) for _ in self._ends]
            for one, end in zip(self._sockets, self._ends, strict=True):
                one.bind((end, 3))
                one.setblocking(False)
            self._thread.start()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        self._stopped.set()
        if self._thread.is_alive():
            self._thread.join()
        for end in self._ends:
            subprocess.run(["ip", "link", "del", end], check=False, capture_output=True)
        for host in self.hosts:
            subprocess.run(["ip", "netns", "del", host], check=False, capture_output=True)

    def command(self, host, command):
        """The command line that runs `command` on host 0 or 1."""
        return ["ip", "netns", "exec", self.hosts[host], *command]

    def _carry(self):
        chance, order, waiting = random.Random(1), itertools.count(), []
        while not self._stopped.is_set():
            timeout = max(0.0, min(0.05, waiting[0][0] - time.monotonic())) if waiting else 0.05
            for one in select.select(self._sockets, [], [], timeout)[0]:
                other = self._sockets[1 - self._sockets.index(one)]
                for _ in range(64):
                    try:
                        packet, (_, _, kind, *_) = one.recvfrom(70_000)
                    except BlockingIOError:
                        break
                    if kind == socket.PACKET_OUTGOING:
                        continue
                    if self.cut or chance.random() < self.loss:
                        self.dropped += 1
                        continue
                    due = time.monotonic() + self.delay + self.jitter * chance.random()
                    heapq.heappush(waiting, (due, next(order), other, packet))
            while waiting and waiting[0][0] <= time.monotonic():
                _, _, other, packet = heapq.heappop(waiting)
                try:
                    other.send(packet)
                    self.carried += 1
                except OSError:
                    self.dropped += 1
