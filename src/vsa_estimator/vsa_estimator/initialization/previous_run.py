# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Start of the filter from the coefficients of a previous run, as after a gap: suspended until they are consistent."""

import numpy as np
from vsa_common.config.configuration import ConfigurationError
from vsa_common.types import Array
from vsa_estimator.fault_detection.consistency import AFTER_GAP, ConsistencyMonitor
from vsa_estimator.fault_detection.residual import Coefficients
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.force_law.state import C
from vsa_estimator.modes import Event, ModeMachine
from vsa_estimator.settings import Initial
from vsa_estimator.tuning.force_law import MAX_LN_STIFFNESS, MIN_K2, MIN_LN_STIFFNESS

# Names of the coefficients in the order of the filter [s k2 d1 d2 M F0 d0], as in EstimatorState.
NAMES = ("ln_stiffness_reference", "k2", "d1", "d2", "inertia", "force_offset", "coulomb_friction")
REQUIRED = NAMES[:2]  # without them the spring is unknown


def coefficients_of(initial: Initial) -> Coefficients | None:
    """Coefficients of `initial.posterior`; None without one.

    A coefficient that it does not have gets its start value, independent of the others; one that the filter does not
    have is left out. Raises ConfigurationError for a covariance that is none, and for a spring that is none.
    """
    posterior = initial.posterior
    if not posterior:
        return None
    missing = [name for name in REQUIRED if name not in posterior.names]
    if missing:
        raise ConfigurationError(f"initial.posterior.names: no {' and no '.join(missing)}")
    given = np.reshape(posterior.covariance, (len(posterior.names), -1))
    _check_covariance(given)
    mean, covariance = np.zeros(len(NAMES)), np.zeros((len(NAMES), len(NAMES)))
    for index, name in enumerate(NAMES):
        if name not in posterior.names:
            mean[index], covariance[index, index] = getattr(initial, name), getattr(initial, f"{name}_std") ** 2
    found = [(NAMES.index(name), at) for at, name in enumerate(posterior.names) if name in NAMES]
    own, others = (list(indices) for indices in zip(*found, strict=True))
    mean[own] = np.array(posterior.values)[others]
    _check_spring(mean)
    covariance[np.ix_(own, own)] = given[np.ix_(others, others)]
    return Coefficients(mean, covariance, posterior.deflection_reference)


def start_from(
    coefficients: Coefficients, tracker: Tracker, modes: ModeMachine, consistency: ConsistencyMonitor
) -> None:
    """Hand the coefficients over to a filter after its first sample."""
    tracker.restore(*coefficients)
    modes.handle(Event.HAND_OVER)
    consistency.begin()
    modes.handle(Event.INCONSISTENT, AFTER_GAP)


def _check_spring(mean: Array) -> None:
    """Raise ConfigurationError for a stiffness or k2 that no transmission has, as a stiffness without its logarithm."""
    s, k2 = float(mean[C.S]), float(mean[C.K2])
    if not MIN_LN_STIFFNESS < s < MAX_LN_STIFFNESS:
        limits = f"{MIN_LN_STIFFNESS:g} to {MAX_LN_STIFFNESS:g}"
        raise ConfigurationError(f"initial.posterior: ln_stiffness_reference {s:g}, not within {limits}")
    if k2 < MIN_K2:
        raise ConfigurationError(f"initial.posterior: k2 {k2:g} 1/m, less than {MIN_K2:g}")


def _check_covariance(covariance: Array) -> None:
    """Raise ConfigurationError unless the matrix is symmetric and positive semidefinite, up to rounding."""
    std = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    correlation = covariance / np.outer(std, std)
    symmetric = np.allclose(correlation, correlation.T, rtol=0.0, atol=1e-6)
    if not symmetric or np.diag(covariance).min() < 0.0 or np.linalg.eigvalsh(correlation).min() < -1e-6:
        raise ConfigurationError("initial.posterior.covariance: not symmetric and positive semidefinite")
