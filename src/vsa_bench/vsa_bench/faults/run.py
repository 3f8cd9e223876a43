# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""One run: a simulated recording, faulty or healthy, through the estimator."""

import math
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from vsa_bench.faults.cases import DEFAULT, FAULTS, TRANSMISSIONS, FaultCase, HealthyCase, form
from vsa_bench.faults.hypotheses import SATURATION, STAMPS_LATE, hypothesis
from vsa_bench.faults.injection import BEGIN_S, faulty
from vsa_bench.faults.metrics import alarms, detect, longest, time_to_valid
from vsa_bench.faults.motions import INTRODUCED, INTRODUCTION_S, simulate
from vsa_bench.faults.observation import Observation, observe
from vsa_bench.faults.stamps import STAMPS
from vsa_common.io.tables import Columns
from vsa_common.types import Array
from vsa_simulator.rig.config import SensorConfig
from vsa_simulator.rig.recording import START_NS, Recording

FAULT_SECONDS = 60.0
READING_PERIOD_S = 0.01  # of the fault texts
HEALTHY_READING_PERIOD_S = 0.1
HAND_OVER_S = 6.0  # healthy figures are taken after this time, and after the introduction of the motion
RECORDED = "stiffness_steps_false_alarm.csv.gz"
RECORDED_COLUMNS = ("stamp", "force", "deflection", "true_stiffness")
RECORDED_START: dict[str, object] = {"initial.k2": 187.0, "initial.k2_std": 90.0}
STAMP_KINDS_LATE = ("late", "busy")
FORCE_RANGE_N = SensorConfig().force_range


def run_fault(case: FaultCase, seed: int, transmission: str = DEFAULT) -> dict[str, Any]:
    """Figures of a fault of one of TRANSMISSIONS, as the JSON has them."""
    recording, stiffness, start = faulty(case, seed, FAULT_SECONDS, transmission)
    seen = observe(recording, start, READING_PERIOD_S, case.rate_hz)
    detection = detect(seen.reports, BEGIN_S)
    wrong = seen.wrong(stiffness) & (seen.time >= BEGIN_S)
    ends = detection.delay if not math.isfinite(case.duration) else case.duration  # when recovery is due [s]
    return {
        "fault": case.fault,
        "form": form(case.duration),
        "motion": case.motion,
        "rate_hz": case.rate_hz,
        "seed": seed,
        "transmission": transmission,
        "expected": FAULTS[case.fault].hypothesis,
        "valid_before": bool(seen.valid[(seen.time >= BEGIN_S - 1.0) & (seen.time < BEGIN_S)].all()),
        "detected_after_s": detection.delay,
        "named": detection.named,
        "named_after_s": detection.named_after,
        "wrong_s": float(wrong.sum()) / case.rate_hz,
        "longest_wrong_s": longest(wrong, 1.0 / case.rate_hz),
        "time_to_valid_s": None if ends is None else time_to_valid(seen.time, seen.valid, BEGIN_S + ends),
    }


def run_healthy(case: HealthyCase, seed: int, seconds: float) -> dict[str, Any]:
    """Figures of healthy motion of `seconds` [s], as the JSON has them."""
    made = simulate(TRANSMISSIONS[case.transmission], case.motion, seconds, case.rate_hz, seed)
    stamp_ns = STAMPS[case.stamps](made.recording.stamp_ns, np.random.default_rng([seed, 3]))
    seen = observe(replace(made.recording, stamp_ns=stamp_ns), made.start, HEALTHY_READING_PERIOD_S, case.rate_hz)
    begin = HAND_OVER_S + (INTRODUCTION_S if case.motion in INTRODUCED else 0.0)
    correct = _correct(made.recording, case.stamps in STAMP_KINDS_LATE)
    return {
        "transmission": case.transmission, "motion": case.motion, "stamps": case.stamps, "rate_hz": case.rate_hz,
        "seed": seed, **healthy_figures(seen, made.stiffness, begin, correct),
    }  # fmt: skip


def run_recorded(columns: Columns) -> dict[str, Any]:
    """Figures of RECORDED: a minute of stiffness steps on a busy machine, columns RECORDED_COLUMNS."""
    time = columns["stamp"] - columns["stamp"][0]
    recording = Recording(START_NS + np.round(1e9 * time).astype(np.int64), columns["force"], columns["deflection"])
    rate_hz = round((len(time) - 1) / float(time[-1]))
    seen = observe(recording, RECORDED_START, HEALTHY_READING_PERIOD_S, rate_hz)
    correct = _correct(recording, stamps_late=True)
    return {
        "transmission": RECORDED.partition(".")[0], "motion": "steps", "stamps": "recorded", "rate_hz": rate_hz,
        "seed": None, **healthy_figures(seen, columns["true_stiffness"], HAND_OVER_S, correct),
    }  # fmt: skip


def _correct(recording: Recording, stamps_late: bool) -> frozenset[str]:
    """Hypotheses that are true of a recording without faults: late stamps, forces beyond the range of the sensor."""
    saturated = bool((np.abs(recording.force) >= FORCE_RANGE_N).any())
    return frozenset(name for name, true in ((STAMPS_LATE, stamps_late), (SATURATION, saturated)) if true)


def healthy_figures(seen: Observation, stiffness: Array, begin: float, correct: frozenset[str]) -> dict[str, Any]:
    """Alarms with the texts beside each, shares of valid and of wrong samples, from `begin` [s] on.

    An alarm whose texts name `correct` hypotheses only is no false one and counts as one of `correct_reports`.
    """
    scored = seen.time >= begin
    begins = [one for one in alarms(seen.time, seen.degraded, seen.fault_resets) if one >= begin]
    texts = [_texts(seen, first, end) for first, end in pairwise([*begins, math.inf])]
    right = [bool(one) and correct.issuperset(map(hypothesis, one)) for one in texts]
    return {
        "hours": float(seen.time[-1] - begin) / 3600.0,
        "alarms": [
            {"at_s": at, "texts": named} for at, named, true in zip(begins, texts, right, strict=True) if not true
        ],
        "correct_reports": sum(right),
        "valid": float(np.mean(seen.valid[scored])),
        "wrong": float(np.mean(seen.wrong(stiffness)[scored])),
    }


def _texts(seen: Observation, begin: float, end: float) -> list[str]:
    return sorted(frozenset().union(*(texts for time, texts in seen.reports if begin <= time < end)))
