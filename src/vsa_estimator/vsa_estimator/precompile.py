# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Compilation of all compiled functions before the first sample."""

import numpy as np
from vsa_common.accel import ACCELERATED
from vsa_estimator.fault_detection.held_law import HeldLaw
from vsa_estimator.fault_detection.parity_check import ParityCheck
from vsa_estimator.fault_detection.residual import Coefficients
from vsa_estimator.fault_detection.travel import EVERYWHERE
from vsa_estimator.filter.measurement_noise import NoiseLevel
from vsa_estimator.filter.output_prediction import predict_output
from vsa_estimator.filter.process_noise import JerkDensity
from vsa_estimator.filter.records import PREDICTION
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.force_law.state import Z
from vsa_estimator.initialization.row_noise import whiten
from vsa_estimator.initialization.windows import BAND
from vsa_estimator.law_comparison import differences, move_to
from vsa_estimator.law_selection import LawSelection
from vsa_estimator.output.predictor import ALIVE, predict, process_sample
from vsa_estimator.output.records import SNAPSHOT
from vsa_estimator.preprocessing.pipeline import Pipeline
from vsa_estimator.settings import EstimatorConfig
from vsa_estimator.tuning.fault_detection import WINDOWS


def precompile(with_bank: bool = False) -> None:
    """Call every compiled function once with arguments of the types that samples have, the bank if `with_bank`."""
    pipeline, tracker, snapshot = Pipeline(EstimatorConfig()), _moving_tracker(), np.zeros(1, SNAPSHOT)
    predict(tracker.state, snapshot, 10**9, 10**9, 0.01, ALIVE)
    whiten(np.ones((BAND + 2, BAND + 1)) + np.eye(BAND + 2, BAND + 1) * 9.0, np.ones((BAND + 2, 2)))
    parity, jerk, noise = ParityCheck(100.0, 4e-3), JerkDensity(), NoiseLevel(1.0, 0.0, 99)
    parity.keep(Coefficients(tracker.z[3:].copy(), tracker.p[3:, 3:].copy(), tracker.reference))
    for stamp_ns in range(0, 10**9, 10**7):
        parity.add((1e-9 * stamp_ns, 0.01, 30.0), 1e-10, False)
        jerk.add(0.01, 1e-10, 0.01)
        noise.add(30.0, 10)
        process_sample(pipeline.state, tracker.state, snapshot, stamp_ns, 30.0, 0.01)
    _ = (
        tracker.sufficient_stroke,
        tracker.beyond_peak_speed,
        pipeline.is_decimating,
    )  # call compiled functions
    parity.accept()
    parity.measure_fault()
    parity.fault_would_show()
    parity.hidden_change()
    parity.isolate_fault()
    if with_bank and ACCELERATED:
        _run_bank()
    noise.refresh()


def _run_bank() -> None:
    """Steps of a bank up to a repetition, with a gap; the filter's output for the comparison; a parity check."""
    initial = EstimatorConfig().initial
    laws = LawSelection(initial, 10.0)
    bank = laws.bank
    for number in range(60):  # 6 s at 1 mm/s: beyond the first repetition
        bank.step(0.1, (0.01 + 1e-4 * number, 1e-10), (30.0, 1e-4))
    while bank.is_repeating:
        bank.repeat_slice()
    bank.follow(0.01, 0.01)
    bank.interrupt(0.01, (0.01, 1e-10))
    law, time = HeldLaw(laws.copied()), 0.01 * np.arange(60)
    rows = np.stack((time, 0.01 + 1e-3 * time, np.full(60, 30.0), np.zeros(60)))[:, 1:]  # strided, as a RowBuffer's
    law.follow(rows, 0.1, 4e-3)
    law.evaluate(rows, 0.1, (*EVERYWHERE, 4e-3), np.zeros((4, len(WINDOWS))))
    law.residuals(rows, 0.1, (*EVERYWHERE, 4e-3))
    law.widened(law.growth(0.01))
    tracker = _moving_tracker()
    prediction = np.zeros(1, PREDICTION)
    predict_output(tracker.state, tracker.reference, 0.0, 0.0, prediction)
    differences(prediction, bank.impedance)
    move_to(prediction, tracker.p[:3, :3], bank.impedance)


def _moving_tracker() -> Tracker:
    """A tracker after two steps in motion."""
    tracker = Tracker(EstimatorConfig().initial, 100.0)
    tracker.start(0.01, 30.0, 1e-10)
    tracker.z[Z.V] = 1e-3
    for _ in range(2):
        tracker.predict(0.01, 1e-3)
        tracker.update_deflection(0.01, 1e-10)
        tracker.update_force(30.0, 1e-4, 1e-10, 0.01)
    tracker.update_uncertainty()
    tracker.predicted_force(tracker.z)
    return tracker
