# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The stored minute of stiffness steps on a busy machine, in which the rod vibrates beyond v*."""

import gzip
from pathlib import Path

import numpy as np
from vsa_bench.faults.run import RECORDED, RECORDED_COLUMNS, run_recorded

STORED = Path(__file__).parents[2] / "golden" / RECORDED


def test_a_minute_of_stiffness_steps_raises_no_alarm_and_keeps_the_stiffness():
    with gzip.open(STORED, "rt") as file:
        columns = np.loadtxt(file, delimiter=",", skiprows=1, usecols=range(len(RECORDED_COLUMNS)), unpack=True)
    figures = run_recorded(dict(zip(RECORDED_COLUMNS, columns, strict=True)))
    assert figures["alarms"] == []
    assert figures["valid"] > 0.99
    assert figures["wrong"] < 0.002
