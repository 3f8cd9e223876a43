# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Records of the filter. Each is the element of a (1,) array that compiled code takes: `state[0]["mean"]`."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from vsa_estimator.force_law.state import SIZE

Record = NDArray[np.void]  # (1,) array of one of the types below

# Standard deviations and variances beyond the covariance, and factors of gradients.
UNCERTAINTY = np.dtype([
    ("k2_variance", "f8"),  # [1/m^2]
    ("d2_variance", "f8"),  # [N^2 s^6/m^6]
    ("inertia_variance", "f8"),  # [kg^2]
    ("inertial_force", "f8"),  # root mean square [N]
    ("stiffness_std", "f8"),  # [N/m]
    ("d1_std", "f8"),  # [N s/m]
    ("d2_std", "f8"),  # [N s^3/m^3]
    ("position_scale", "f8"),  # factor of the gradient by position, from innovation covariance matching
    ("velocity_scale", "f8"),  # factor of the gradient by velocity
])  # fmt: skip

FILTER_STATE = np.dtype([
    ("mean", "f8", (SIZE,)),  # order of `force_law.state.Z`
    ("friction_bias", "f8", (SIZE,)),  # sensitivity of the mean to the form of the friction law (consider parameter)
    ("covariance", "f8", (SIZE, SIZE)),
    ("uncertainty", UNCERTAINTY),
])  # fmt: skip

# Moments are leaky means over EXCITATION_TIME_CONSTANT, those of the matching over MATCHING_TIME_CONSTANT.
EXCITATION = np.dtype([
    ("position_max", "f8"), ("position_min", "f8"),  # [m]
    ("velocity_square", "f8"),  # without the variance of the estimate [m^2/s^2]
    ("acceleration_square", "f8"),  # without the variance of the estimate [m^2/s^4]
    ("beyond_peak_share", "f8"),  # share of time near or beyond v*
    ("time_since_motion", "f8"),  # time without a significant speed [s]
    ("weight", "f8"),  # of the four means below: 1 in steady state
    ("mean_x", "f8"), ("mean_a", "f8"),  # x from the reference [m], acceleration [m/s^2]
    ("mean_xx", "f8"), ("mean_xa", "f8"),  # [m^2, m^2/s^2]
    ("matching_weight", "f8"),  # of the two means below: 1 in steady state
    ("predicted_var", "f8"),  # of the force by position and speed, from the covariance [N^2]
    ("observed_var", "f8"),  # of the same, from the innovations [N^2]
])  # fmt: skip

MONITOR = np.dtype([
    ("innovation", "f8"),  # [N or m]
    ("variance", "f8"),  # of the innovation
    ("nis", "f8"),  # normalised innovation squared, before any inflation
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

# Sample statistics of one sensor: the last three means, how many came without a gap, how many differences were taken.
NOISE_LEVEL = np.dtype([("means", "f8", (3,)), ("run_length", "i8"), ("differences", "i8")])


class ForceMeasurement(NamedTuple):
    """One force with what its update needs beside the state, SI."""

    force: float  # [N]
    variance: float  # [N^2]
    deflection_variance: float  # of the encoder at the same step [m^2]
    reference: float  # of s [m]
    dt: float  # since the force before [s]


def initial_state() -> Record:
    """(1,) FILTER_STATE, zero but for the scales, which are 1."""
    state = np.zeros(1, FILTER_STATE)
    state["uncertainty"]["position_scale"] = state["uncertainty"]["velocity_scale"] = 1.0
    return state


def initial_excitation() -> Record:
    """(1,) EXCITATION before any motion."""
    return np.zeros(1, EXCITATION)


def initial_monitor() -> Record:
    """(1,) MONITOR before any measurement; the variance 1 keeps the NIS finite."""
    monitor = np.zeros(1, MONITOR)
    monitor["variance"] = 1.0
    return monitor
