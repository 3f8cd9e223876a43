# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Identification from a bag: `external_torque` and `joint_states` with held motors."""

from pathlib import Path

import numpy as np
from vsa_common.io.bags import read
from vsa_common.stamps import nanoseconds
from vsa_common.types import Array
from vsa_joint.experiment.identification import Identified, average, from_motion
from vsa_joint.impedance.reflection import Joint

RATE_HZ = 200.0  # of the resampled signals
MAX_GAP = 0.1  # s


def identify_bag(bag: Path, joint: Joint, period: float, namespace: str = "/vsa") -> Identified:
    """Impedance of the joint from the last whole periods of a bag without the first one.

    `period` [s] is that of the external torque. Raises BagError for an unreadable bag, ValueError for missing
    signals, gaps, or less than two periods.
    """
    torque_topic, angle_topic = f"{namespace}/external_torque", f"{namespace}/joint_states"
    rows: dict[str, list[tuple[float, float]]] = {torque_topic: [], angle_topic: []}
    for topic, _, message in read(bag, list(rows)):
        value = message.wrench.torque.z if topic == torque_topic else message.position[0]
        rows[topic].append((nanoseconds(message.header.stamp), value))
    for topic, samples in rows.items():
        if len(samples) < 2:
            raise ValueError(f"{bag}: {topic}: {len(samples)} messages; expected the whole experiment")
    series = {topic: np.array(sorted(samples), dtype=float) for topic, samples in rows.items()}
    return identify_series(series[angle_topic], series[torque_topic], joint, period)


def identify_series(angle: Array, torque: Array, joint: Joint, period: float) -> Identified:
    """The same from arrays (n, 2) of stamp [ns] and value (rad, N m)."""
    begin, end = max(angle[0, 0], torque[0, 0]), min(angle[-1, 0], torque[-1, 0])
    for name, rows in (("joint_states", angle), ("external_torque", torque)):
        inside = rows[(rows[:, 0] >= begin) & (rows[:, 0] <= end), 0]
        gap = float(np.diff(inside).max()) * 1e-9 if len(inside) > 1 else np.inf
        if gap > MAX_GAP:
            raise ValueError(f"{name}: {gap:.2f} s without a sample; expected {MAX_GAP} s at most")
    periods = int((end - begin) * 1e-9 // period)
    if periods < 2:
        raise ValueError(f"{(end - begin) * 1e-9:.1f} s of both signals; expected two periods of {period} s at least")
    used = (periods - 1) * round(period * RATE_HZ)
    grid = end - 1e9 / RATE_HZ * np.arange(used - 1, -1, -1)
    angles, torques = (np.interp(grid, rows[:, 0], rows[:, 1]) for rows in (angle, torque))
    return from_motion(average(angles, torques, RATE_HZ, period), joint)
