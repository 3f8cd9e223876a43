# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Record between two filter steps: what every sample's estimate is predicted from."""

import numpy as np
from vsa_estimator.general.records import IMPEDANCE
from vsa_estimator.output.estimate import Estimate

# Fields of an estimate that are constant between two steps.
CONSTANT_FIELDS = Estimate._fields[Estimate._fields.index("reset_count") :]

PUBLISHED = np.dtype([
    ("is_current", "?"),  # whether nothing but a prediction is due before the next step
    ("reference", "f8"),  # of ln stiffness [m]
    ("jerk_density", "f8"),  # [m^2/s^5]
    ("deflection_noise_variance", "f8"),  # [m^2]
    ("suspended", "?"), ("initialized", "?"),  # the operating mode
    ("model_inadequate", "?"),
    ("inertia_observable", "?"),
    ("step_ns", "i8"),  # instant of the last step
    ("fault_until_ns", "i8"),  # stamp until which a fault is active
    ("sensor_fault_until_ns", "i8"),  # the same for a fault of a sensor: not for a delay
    ("general", "?"), ("impedance", IMPEDANCE),  # of the bank, where it estimates
    ("stiffness_discrepancy", "f8"), ("damping_discrepancy", "f8"),  # of the filter: variances of ln stiffness, damping
    *((name, "f8") for name in CONSTANT_FIELDS),
])  # fmt: skip

SNAPSHOT = np.dtype([
    ("previous_outlier", "?"),  # whether the last deflection was beyond the position gate
    ("position_inflation", "f8"),  # [m^2]
    ("published", PUBLISHED),  # written after each step
])  # fmt: skip
