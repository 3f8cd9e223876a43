# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Streams of transmission estimates for the tests of the joint fusion."""

from vsa_common.config.configuration import build
from vsa_common.types import Status
from vsa_joint.impedance.fusion import JointFusion
from vsa_joint.impedance.pairing import TransmissionEstimate
from vsa_joint.impedance.propagation import ImpedanceEstimate
from vsa_joint.settings import JointConfig

MS = 1_000_000
GOOD = TransmissionEstimate(
    0, 40.0, 1e-4, True, ImpedanceEstimate(2300.0, 4000.0, 0.37, 100.0, 400.0, 1e-4), True, True, True, Status.VALID
)


def fusion(**values):
    return JointFusion(build(JointConfig, values))


def feed(core, index, stamp_ms, now_ms=None, **changes):
    stamp = int(stamp_ms * MS)
    return core.add(index, GOOD._replace(stamp_ns=stamp, **changes), int((stamp_ms if now_ms is None else now_ms) * MS))


def run(core, until, lost=(), offset=0.1, first=0):
    """Both transmissions at 1 kHz, the second `offset` ms later; `lost` has (transmission, sample)."""
    out = []
    for k in range(first, until):
        for index, stamp in ((0, k), (1, k + offset)):
            if (index, k) not in lost:
                estimate = feed(core, index, stamp)
                out += [estimate] if estimate else []
    return out


def skews_ms(estimates):
    return [abs(a - b) / MS for a, b in (e.transmission_stamp_ns for e in estimates)]
