# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Figures of merit of a recorded run against the rig's truth: arrays in, the numbers of summary.json out.

The rolling counter of a CAN frame assigns an estimate to a sample of the rig. Errors are those of the last 30 % of the
run, over every message there, valid or not.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from vsa_joint.impedance.reflection import branch_at_joint
from vsa_tools.evaluation.recorded_run import Floats, Integers

Columns = Mapping[str, Floats]

SCORED = 0.3  # evaluated fraction at the end of the run [1]: the estimates have converged by then
CONVERGED = 0.05  # relative error of stiffness below which it counts as converged [1], the usual 5 % settling band
TRANSIENT = 0.1  # longest excursion beyond that band that ends no convergence [s]: a step of the stiffness takes 0.2 s
Z95 = 1.959964  # half width of the 95 % interval in standard deviations [1]


@dataclass(frozen=True)
class Series:
    """Estimates of one quantity with their standard deviations."""

    value: Floats
    std: Floats

    def __getitem__(self, where: Any) -> "Series":
        return Series(self.value[where], self.std[where])


@dataclass(frozen=True)
class Coefficient:
    """One coefficient of a transmission at the end of the run."""

    start: float
    estimate: float
    std: float
    truth: float | None  # None: not defined for the rig's law


@dataclass(frozen=True)
class Transmission:
    """One transmission: sample number of each estimate, and `fused`, the estimator's own count of samples."""

    fused: int
    sample: Integers
    stiffness: Series
    damping: Series
    coefficients: Mapping[str, Coefficient]  # k2, d2, inertia; SI; stiffness and damping for other laws than (2), (5)
    inertia_valid: bool


@dataclass(frozen=True)
class JointRun:
    """The joint: sample number of each side for each message."""

    samples: tuple[Integers, Integers]
    stiffness: Series
    damping: Series


@dataclass(frozen=True)
class Geometry:
    """Geometry between the simulated rig's transmissions and its joint."""

    radius: float  # [m]
    tendon_stiffness: tuple[float, float]  # [N/m]
    joint_damping: float  # [N m s/rad]


def transmission_summary(run: Transmission, truth: Columns, side: int, rate_hz: float) -> dict[str, Any]:
    """Figures of transmission `side` (1 or 2); the rig samples at `rate_hz` [Hz]."""
    sent = len(truth["stiffness_1"])
    assigned = (run.sample >= 0) & (run.sample < sent)
    sample, stiffness, damping = run.sample[assigned], run.stiffness[assigned], run.damping[assigned]
    true_stiffness, true_damping = truth[f"stiffness_{side}"][sample], truth[f"damping_{side}"][sample]
    late = sample >= (1.0 - SCORED) * sent
    return {
        "samples_sent": sent,
        "samples_fused": run.fused,
        "samples_lost": sent - run.fused,
        "converged_after_s": converged_after(sample / rate_hz, stiffness.value, true_stiffness),
        **{name: vars(coefficient).copy() for name, coefficient in run.coefficients.items() if name != "inertia"},
        "inertia": {**vars(run.coefficients["inertia"]), "valid": run.inertia_valid},
        "stiffness_nrmse": nrmse(stiffness.value[late], true_stiffness[late]),
        "damping_nrmse": nrmse(damping.value[late], true_damping[late]),
        "stiffness_coverage95": log_coverage(stiffness[late], true_stiffness[late]),
        "damping_coverage95": coverage(damping[late], true_damping[late]),
    }


def joint_summary(run: JointRun, truth: Columns, geometry: Geometry) -> dict[str, Any]:
    """Figures of the joint."""
    sent = len(truth["stiffness_1"])
    first, second = run.samples
    late = (np.minimum(first, second) >= (1.0 - SCORED) * sent) & (np.maximum(first, second) < sent)
    stiffness, damping = joint_truth(truth, (first[late], second[late]), geometry)
    return {
        "messages": len(first),
        "stiffness_nrmse": nrmse(run.stiffness.value[late], stiffness),
        "damping_nrmse": nrmse(run.damping.value[late], damping),
        "stiffness_coverage95": log_coverage(run.stiffness[late], stiffness),
    }


def joint_truth(truth: Columns, samples: tuple[Integers, Integers], geometry: Geometry) -> tuple[Floats, Floats]:
    """Stiffness [N m/rad] and damping [N m s/rad] of the joint at low frequency, eqs. (10), (11), (13).

    (13) has the factor 1/4 of virtual work: a rod moves half as far as its tendon and carries twice its tension.
    """
    stiffness = np.zeros(len(samples[0]))
    damping = np.full(len(samples[0]), geometry.joint_damping)
    for side, (sample, tendon) in enumerate(zip(samples, geometry.tendon_stiffness, strict=True), 1):
        sigma, rod_damping = truth[f"stiffness_{side}"][sample], truth[f"damping_{side}"][sample]
        stiffness += branch_at_joint(sigma, geometry.radius, tendon)
        damping += geometry.radius**2 * rod_damping * (2.0 * tendon / (4.0 * tendon + sigma)) ** 2
    return stiffness, damping


def converged_after(time: Floats, estimate: Floats, truth: Floats) -> float | None:
    """Time [s] from which on the relative error exceeds CONVERGED for TRANSIENT at most; None if it does not."""
    outside = np.concatenate([[False], ~(np.abs(estimate - truth) <= CONVERGED * np.abs(truth)), [False]])
    begin, end = np.flatnonzero(np.diff(outside.astype(int))).reshape(-1, 2).T  # of the excursions
    ends = np.append(time, np.inf)[end]
    lasting = ends[ends - time[begin] > TRANSIENT]
    if not len(lasting):
        return 0.0 if len(time) else None
    return float(lasting[-1]) if lasting[-1] < np.inf else None


def nrmse(estimate: Floats, truth: Floats) -> float | None:
    """rms error / rms truth [1]; None without a sample."""
    if not len(truth):
        return None
    return float(np.sqrt(np.mean((estimate - truth) ** 2) / np.mean(truth**2)))


def coverage(estimate: Series, truth: Floats) -> float | None:
    """Fraction of samples whose 95 % interval contains the truth; None without a sample."""
    return float(np.mean(np.abs(estimate.value - truth) <= Z95 * estimate.std)) if len(truth) else None


def log_coverage(estimate: Series, truth: Floats) -> float | None:
    """As `coverage`, for a positive quantity with the interval value * exp(+-Z95 std / value)."""
    if not len(truth):
        return None
    value = np.maximum(estimate.value, np.finfo(float).tiny)
    return float(np.mean(np.abs(np.log(value / truth)) <= Z95 * estimate.std / value))


def latency_summary(latency_ns: Integers) -> dict[str, float | None]:
    """Median, 99th percentile and maximum [ms]."""
    if not len(latency_ns):
        return {"p50": None, "p99": None, "max": None}
    p50, p99, largest = np.percentile(latency_ns, [50.0, 99.0, 100.0]) / 1e6
    return {"p50": round(float(p50), 3), "p99": round(float(p99), 3), "max": round(float(largest), 3)}
