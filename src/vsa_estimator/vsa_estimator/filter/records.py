"""Records of the filter: state with covariance, what is known beyond the covariance, and a predicted output.

Each lies in an array of one element, which compiled code takes: `state[0]["mean"]`.
"""

import numpy as np
from vsa_estimator.force_law.transmission import SIZE

# Standard deviations and variances beyond the covariance, and shares of the covariance that count.
UNCERTAINTY = np.dtype([
    ("k2_variance", "f8"),  # [1/m^2]
    ("d2_variance", "f8"),  # [N^2 s^6/m^6]
    ("inertia_variance", "f8"),  # [kg^2]
    ("inertial_force", "f8"),  # root mean square [N]
    ("stiffness_std", "f8"),  # [N/m]
    ("d1_std", "f8"),  # [N s/m]
    ("d2_std", "f8"),  # [N s^3/m^3]
    ("inertia_variance_reported", "f8"),  # [kg^2]
    ("position_scale", "f8"),  # factor of the gradient by position, from innovation covariance matching
    ("velocity_scale", "f8"),  # factor of the gradient by velocity
])  # fmt: skip

FILTER_STATE = np.dtype([
    ("mean", "f8", (SIZE,)),  # order of `force_law.transmission.Z`
    ("friction_bias", "f8", (SIZE,)),  # sensitivity of the mean to the form of the friction law (consider parameter)
    ("covariance", "f8", (SIZE, SIZE)),
    ("uncertainty", UNCERTAINTY),
])  # fmt: skip

PREDICTION = np.dtype([
    ("deflection", "f8"), ("deflection_variance", "f8"),  # [m, m^2]
    ("velocity", "f8"), ("velocity_variance", "f8"),  # [m/s]
    ("acceleration", "f8"), ("acceleration_variance", "f8"),  # [m/s^2]
    ("stiffness", "f8"), ("ln_stiffness_variance", "f8"),  # [N/m, 1]
    ("damping", "f8"), ("damping_variance", "f8"),  # [N s/m]
    ("inertia", "f8"), ("inertia_variance", "f8"),  # [kg]
    ("stiffness_damping_covariance", "f8"),
    ("stiffness_inertia_covariance", "f8"),
    ("damping_inertia_covariance", "f8"),
    ("peak_speed", "f8"),  # v* [m/s]
])  # fmt: skip
