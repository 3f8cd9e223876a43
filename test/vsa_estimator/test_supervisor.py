# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Which evidence suspends the updates of the filter."""

from transmission_data import SLOW, TRANSMISSION_1, record, wrong_start
from vsa_estimator.estimator import Estimator
from vsa_estimator.fault_detection.consistency import AFTER_FAULT, ConsistencyMonitor
from vsa_estimator.modes import Mode
from vsa_estimator.tuning.filter import NIS_CAP, NIS_WINDOW

RATE, SECONDS = 100, 30.0


def tracking():
    """Estimator and its further samples after SECONDS of a motion."""
    recording = record(TRANSMISSION_1, SLOW, SECONDS + 1.0, RATE)
    columns = recording.stamp_ns, recording.force, recording.deflection
    samples = list(zip(*(column.tolist() for column in columns), strict=True))
    estimator = Estimator(wrong_start(TRANSMISSION_1))
    for sample in samples[: round(SECONDS * RATE)]:
        estimator.add(*sample)
    assert estimator._supervisor.modes.mode is Mode.TRACKING
    return estimator, samples[round(SECONDS * RATE) :]


def test_innovations_that_the_parity_check_has_explained_are_no_evidence_when_it_has_none(monkeypatch):
    estimator, samples = tracking()
    supervisor = estimator._supervisor

    def add(sample):
        for _ in range(round(0.5 * NIS_WINDOW * RATE)):
            supervisor.tracker._nis_test.add(NIS_CAP)
        estimator.add(*sample)

    assert supervisor.consistency.is_consistent
    add(samples[0])
    monkeypatch.setattr(ConsistencyMonitor, "is_consistent", False)
    add(samples[1])
    assert supervisor.modes.mode is Mode.TRACKING
    add(samples[2])
    assert supervisor.modes.mode is Mode.SUSPENDED


def test_after_an_encoder_fault_the_updates_are_suspended_without_a_report_of_an_inconsistency():
    estimator, samples = tracking()
    stamp_ns, force, deflection = samples[0]
    for i in range(20):  # queued, all within 10 ms
        estimator.add(stamp_ns + i * 500_000, force, deflection)
    assert estimator._supervisor.modes.reason == AFTER_FAULT
