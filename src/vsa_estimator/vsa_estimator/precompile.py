"""Compile ahead of the first sample what is compiled."""

import numpy as np
from vsa_estimator.fault_detection.parity_check import Coefficients, ParityCheck
from vsa_estimator.filter.measurement_noise import NoiseLevel
from vsa_estimator.filter.process_noise import JerkDensity
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.initialization.windows import BAND, whiten
from vsa_estimator.output.predictor import SNAPSHOT, predict_row, process_sample
from vsa_estimator.preprocessing.pipeline import Pipeline
from vsa_estimator.settings import EstimatorConfig


def precompile() -> None:
    """Run every compiled function once, so that the first samples do not wait for the compiler."""
    tracker = Tracker(EstimatorConfig().initial, 100.0)
    tracker.start(0.01, 30.0, 1e-10)
    tracker.z[1] = 1e-3
    for _ in range(2):
        tracker.predict(0.01, 1e-3)
        tracker.update_deflection(0.01, 1e-10)
        tracker.update_force(30.0, 1e-4, 1e-10, 0.01)
    tracker.update_uncertainty()
    beliefs, moments = np.zeros(SNAPSHOT), np.zeros(2, dtype=np.int64)
    samples, sufficient = Pipeline(EstimatorConfig()), tracker.sufficient_stroke
    predict_row(
        tracker.state,
        beliefs,
        moments,
        10**9,
        10**9,
        0.01,
        sufficient,
        tracker.beyond_peak_speed,
        samples.is_decimating,
    )
    tracker.predicted_force(0.01)
    whiten(np.ones((BAND + 2, BAND + 1)) + np.eye(BAND + 2, BAND + 1) * 9.0, np.ones((BAND + 2, 2)))
    witness, jerk, noise = ParityCheck(100.0), JerkDensity(), NoiseLevel(1.0, 0.0, 99)
    witness.keep(Coefficients(tracker.z[3:].copy(), tracker.p[3:, 3:].copy(), tracker.reference))
    for stamp_ns in range(0, 10**9, 10**7):
        witness.add(1e-9 * stamp_ns, 0.01, 30.0)
        jerk.add(0.01, 1e-10, 0.01)
        noise.add(30.0, 10)
        process_sample(samples.state, tracker.state, beliefs, moments, stamp_ns, 30.0, 0.01)
    witness.isolate_fault()
    noise.refresh()
