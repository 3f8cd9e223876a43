"""A corner of this machine for one run alone: its own ROS domain and its own port of the CAN bus."""

import os
import random
import socket
from collections.abc import Mapping
from dataclasses import dataclass

DOMAINS = range(20, 101)  # above 101 the ports of DDS run into those that Linux hands out
BUS_PORT = 61_000  # above those that Linux hands out


class IsolationError(RuntimeError):
    """All corners are taken."""


@dataclass(frozen=True)
class IsolatedDomain:
    """One ROS domain, held until this process ends."""

    domain: int
    lock: socket.socket

    @property
    def bus_port(self) -> int:
        """UDP port of the CAN bus."""
        return BUS_PORT + self.domain

    def environment(self) -> dict[str, str]:
        """Environment for the nodes of the run: they hear each other, on this machine, and nobody else."""
        inherited: Mapping[str, str] = {k: v for k, v in os.environ.items() if k != "ROS_LOCALHOST_ONLY"}
        return {
            **inherited,
            "ROS_DOMAIN_ID": str(self.domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "PYTHONUNBUFFERED": "1",
        }


def claim_domain() -> IsolatedDomain:
    """A domain that no other run on this machine has claimed. Raises IsolationError where there is none."""
    for domain in random.sample(DOMAINS, len(DOMAINS)):
        lock = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            lock.bind(f"\0vsa_domain_{domain}")  # an abstract name: it vanishes with the process
            return IsolatedDomain(domain, lock)
        except OSError:
            lock.close()
    raise IsolationError(f"ROS domains {DOMAINS[0]} to {DOMAINS[-1]} are all taken by other runs")
