# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""State message with the choice of the law: the bank where it is published, else the filter with its variance."""

import math

from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.law_choice import LawChoice
from vsa_estimator.output.elastic_law import ElasticLaw
from vsa_estimator.output.estimate import State
from vsa_estimator.tuning.output import MAX_K2_STD, MAX_STIFFNESS_STD

SCALARS = ("ln_stiffness", "ln_stiffness_variance", "slope", "slope_variance", "rest_damping", "level", "coulomb")

Coefficients = tuple[float, float, float, float, float, float]  # k2, variance, d2, variance, force offset, friction


def published_coefficients(tracker: Tracker, laws: LawChoice) -> Coefficients:
    """Published coefficients; k2 of the bank is the local slope of ln sigma, d2 is not defined there."""
    if laws.replaces_filter:
        now = laws.impedance[0]
        return (
            float(now["slope"]), float(now["slope_variance"]), 0.0, 0.0, float(now["level"]), float(now["coulomb"])
        )  # fmt: skip
    known = tracker.uncertainty
    return known.k2, known.k2_variance, known.d2, known.d2_variance, known.force_offset, known.coulomb_friction


def elastic_law(laws: LawChoice) -> ElasticLaw | None:
    """The elastic law of the bank; None without data."""
    law = laws.bank.elastic_law() if laws.bank is not None else None
    if law is None:
        return None
    knots, ln_stiffness, covariance, force = law
    numbers = [tuple(one.ravel().tolist()) for one in (knots, ln_stiffness, covariance)]
    return ElasticLaw(laws.description, numbers[0], numbers[1], numbers[2], force)


def with_choice(state: State, laws: LawChoice) -> State:
    """The state of the filter, with what the choice of the law leaves open in its ln stiffness, or with the bank's."""
    if laws.replaces_filter:
        return with_bank(state, laws)
    added = laws.discrepancies[0]
    variance = state.ln_stiffness_reference_variance + added
    first, *others = state.coefficient_covariance
    return state._replace(
        coefficient_covariance=(first + added, *others),
        ln_stiffness_reference_variance=variance,
        ln_stiffness_reference_valid=state.ln_stiffness_reference_valid and variance < MAX_STIFFNESS_STD**2,
        elastic_ln_stiffness_covariance=tuple(entry + added for entry in state.elastic_ln_stiffness_covariance),
    )


def with_bank(state: State, laws: LawChoice) -> State:
    """The state of the filter with the bank's impedance in place of the coefficients of the exponential law.

    ln stiffness and k2 are those at the present deflection, which is the reference; d1 is the damping at rest.
    """
    now = {name: float(laws.impedance[0][name]) for name in SCALARS}
    elastic, variance = elastic_law(laws), now["ln_stiffness_variance"]
    relative = math.sqrt(now["slope_variance"]) / max(abs(now["slope"]), 1e-9)
    valid = variance < MAX_STIFFNESS_STD**2
    k2_valid = valid and relative < MAX_K2_STD
    lines = tuple(line for line in state.observability if not (k2_valid and line.startswith("k2")))
    return state._replace(
        deflection_reference=state.deflection,
        ln_stiffness_reference=now["ln_stiffness"],
        ln_stiffness_reference_variance=variance,
        ln_stiffness_reference_valid=valid,
        k2=now["slope"], k2_variance=now["slope_variance"], k2_valid=k2_valid,
        d1=now["rest_damping"], d1_valid=False, d2=0.0, d2_variance=0.0, d2_valid=False,
        inertia_valid=False, force_offset=now["level"], force_offset_valid=False,
        coulomb_friction=now["coulomb"], coulomb_friction_valid=False,
        observability=(f"law: {laws.description}; k2 is the local slope of ln stiffness", *lines),
        **(elastic.fields(state.elastic_law_valid) if elastic else {}),
    )  # fmt: skip
