"""Compile ahead of the first sample what is compiled."""

import numpy as np
from vsa_estimator.assessment import assess
from vsa_estimator.blocks import Block
from vsa_estimator.jerk import JerkDensity
from vsa_estimator.noise_level import NoiseLevel
from vsa_estimator.rows import BAND, whiten
from vsa_estimator.samples import Samples, take
from vsa_estimator.settings import EstimatorConfig
from vsa_estimator.tracker import Tracker
from vsa_estimator.trust import Trust


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
    found = tracker.appraisal
    assess(tracker.known, np.zeros(2), 0.01, 0.001, 1e-3, 0.01, 1e-10, True, True, True, found.inertial_force > 0.0)
    whiten(np.ones((BAND + 2, BAND + 1)) + np.eye(BAND + 2, BAND + 1) * 9.0, np.ones((BAND + 2, 2)))
    trust, jerk, noise, samples = Trust(100.0), JerkDensity(), NoiseLevel(1.0, 0.0, 9), Samples(EstimatorConfig())
    for stamp_ns in range(0, 10**9, 10**7):
        trust.weigh(tracker, 1e-9 * stamp_ns, Block(stamp_ns, 0.01, 30.0, 1, 1), False)
        jerk.add(0.01, 1e-10, 0.01)
        noise.add(30.0, 10)
        take(samples.memory, samples.stamps, stamp_ns, 30.0, 0.01)
