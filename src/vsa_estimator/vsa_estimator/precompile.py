"""Compile ahead of the first sample what is compiled."""

import numpy as np
from vsa_estimator.fault_detection.parity_check import Coefficients, Witness
from vsa_estimator.filter.measurement_noise import NoiseLevel
from vsa_estimator.filter.process_noise import JerkDensity
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.initialization.windows import BAND, whiten
from vsa_estimator.output.predictor import BELIEFS, assess, follow
from vsa_estimator.preprocessing.pipeline import Samples
from vsa_estimator.settings import EstimatorConfig


def warm_up() -> None:
    """Run every compiled function once, so that the first samples do not wait for the compiler."""
    tracker = Tracker(EstimatorConfig().initial, 100.0)
    tracker.start(0.01, 30.0, 1e-10)
    tracker.z[1] = 1e-3
    tracker.knows = True
    for _ in range(2):
        tracker.predict(0.01, 1e-3)
        tracker.correct_deflection(0.01, 1e-10)
        tracker.correct_force(30.0, 1e-4, 1e-10, 0.01)
    beliefs, moments = np.zeros(BELIEFS), np.zeros(2, dtype=np.int64)
    samples, heavy = Samples(EstimatorConfig()), tracker.appraisal.inertia_variance > 1.0
    assess(tracker.known, beliefs, moments, 10**9, 10**9, 0.01, heavy, tracker.undamped, samples.averaged)
    tracker.expected_force(0.01)
    whiten(np.ones((BAND + 2, BAND + 1)) + np.eye(BAND + 2, BAND + 1) * 9.0, np.ones((BAND + 2, 2)))
    witness, jerk, noise = Witness(100.0), JerkDensity(), NoiseLevel(1.0, 0.0, 99)
    witness.keep(Coefficients(tracker.z[3:].copy(), tracker.p[3:, 3:].copy(), tracker.reference))
    for stamp_ns in range(0, 10**9, 10**7):
        witness.add(1e-9 * stamp_ns, 0.01, 30.0)
        jerk.add(0.01, 1e-10, 0.01)
        noise.add(30.0, 10)
        follow(samples.memory, samples.stamps, tracker.known, beliefs, moments, stamp_ns, 30.0, 0.01)
    witness.explain()
    noise.refresh()
