# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Isolation of one run on this machine: a ROS domain and a UDP port of the CAN bus of its own."""

import os
import random
import socket
from collections.abc import Mapping
from dataclasses import dataclass

DOMAINS = range(20, 101)  # above 101 the ports of DDS overlap the ephemeral ports of Linux
BUS_PORT = 61_000  # of domain 0, above the ephemeral ports of Linux


class IsolationError(RuntimeError):
    """No ROS domain is free."""


@dataclass(frozen=True)
class IsolatedDomain:
    """One ROS domain, reserved until this process ends."""

    domain: int
    lock: socket.socket

    @property
    def bus_port(self) -> int:
        """UDP port of the CAN bus."""
        return BUS_PORT + self.domain

    def environment(self) -> dict[str, str]:
        """Environment of the nodes of the run: discovery on this machine and in this domain only."""
        inherited: Mapping[str, str] = {k: v for k, v in os.environ.items() if k != "ROS_LOCALHOST_ONLY"}
        return {
            **inherited,
            "ROS_DOMAIN_ID": str(self.domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "PYTHONUNBUFFERED": "1",
        }


def claim_domain() -> IsolatedDomain:
    """Reserve a domain that no other run on this machine holds. Raises IsolationError where none is free."""
    for domain in random.sample(DOMAINS, len(DOMAINS)):
        lock = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            lock.bind(f"\0vsa_domain_{domain}")  # an abstract name: the kernel releases it with the process
            return IsolatedDomain(domain, lock)
        except OSError:
            lock.close()
    raise IsolationError(f"ROS domains {DOMAINS[0]} to {DOMAINS[-1]} are all in use by other runs")
