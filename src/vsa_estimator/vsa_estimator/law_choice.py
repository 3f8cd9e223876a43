# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Choice between the filter of the exponential law and the bank of laws: what is published, and the mode."""

import math

import numpy as np
from vsa_common.accel import ACCELERATED
from vsa_estimator.filter.output_prediction import predict_output
from vsa_estimator.filter.records import PREDICTION
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.general.records import IMPEDANCE, Record
from vsa_estimator.general.selection import LawSelection
from vsa_estimator.law_comparison import LawComparison
from vsa_estimator.modes import Mode, ModeMachine
from vsa_estimator.output.elastic_law import ElasticLaw
from vsa_estimator.output.estimate import State
from vsa_estimator.preprocessing.decimator import Decimated
from vsa_estimator.settings import EstimatorConfig
from vsa_estimator.tuning.general import REJECTION
from vsa_estimator.tuning.output import MAX_K2_STD, MAX_PREDICTION_TIME, MAX_STIFFNESS_STD

NO_IMPEDANCE = np.zeros(1, IMPEDANCE)

SCALARS = ("ln_stiffness", "ln_stiffness_variance", "slope", "slope_variance", "rest_damping", "level", "coulomb")

Coefficients = tuple[float, float, float, float, float, float]  # k2, variance, d2, variance, force offset, friction


class LawChoice:
    """The bank of laws beside the filter; none where the law is fixed, and in plain Python, which is too slow."""

    def __init__(self, config: EstimatorConfig) -> None:
        """Before the first step."""
        automatic = config.elastic_law == "automatic" and ACCELERATED
        self._laws = LawSelection(config.initial, config.filter_rate) if automatic else None
        self._comparison, self._prediction = LawComparison(), np.zeros(1, PREDICTION)
        self._chosen_ns = 0
        self.publishes_bank = False

    @property
    def is_repeating(self) -> bool:
        """Whether the bank repeats its steps."""
        return self._laws is not None and not self._laws.is_confirmed and self._laws.bank.is_repeating

    @property
    def impedance(self) -> Record:
        """(1,) IMPEDANCE of the bank; zero without one."""
        return self._laws.impedance if self._laws is not None else NO_IMPEDANCE

    @property
    def description(self) -> str:
        """The bank's most probable model, where the bank is published; else empty."""
        return self._laws.bank.description if self._laws is not None and self.publishes_bank else ""

    def elastic_law(self) -> ElasticLaw | None:
        """The elastic law of the bank; None without data."""
        law = self._laws.bank.elastic_law() if self._laws is not None else None
        if law is None:
            return None
        knots, ln_stiffness, covariance, force = law
        numbers = [tuple(one.ravel().tolist()) for one in (knots, ln_stiffness, covariance)]
        return ElasticLaw(self.description, numbers[0], numbers[1], numbers[2], force)

    def repeat_slice(self) -> None:
        """Do a part of a repetition."""
        if self._laws is not None and not self._laws.is_confirmed:
            self._laws.bank.repeat_slice()

    def restart(self) -> None:
        """Drop the data: the position is no longer valid."""
        if self._laws is not None:
            self._laws.restart()
            self._comparison.restart()

    def confirm(self) -> None:
        """The exponential law holds, by a previous run."""
        if self._laws is not None:
            self._laws.is_confirmed = True

    def reject(self) -> None:
        """The filter's coefficients are given up; the bank drops its data unless it explains the force.

        A law that is confirmed keeps its form: its coefficients are estimated again.
        """
        if self._laws is not None and not self._laws.is_confirmed and not self._laws.is_adequate:
            self.restart()

    def interrupt(self) -> None:
        """The motion has a gap before the next step."""
        if self._laws is not None:
            self._laws.interrupt()

    def shift(self, offset: float) -> None:
        """The encoder reads `offset` [m] more from now on."""
        if self._laws is not None:
            self._laws.shift(offset)

    def step(self, block: Decimated, noise: tuple[float, float], modes: ModeMachine) -> bool:
        """Step the bank by a block with the variances `noise` of deflection [m^2] and force [N^2].

        Whether the operating mode has to change: the exponential law is refuted and the filter inconsistent with the
        bank, or in mode GENERAL no law explains the force.
        """
        if self._laws is None:
            return False
        force = block.force if block.forces else math.nan
        self._laws.step(block.stamp_ns, (block.deflection, noise[0]), (force, noise[1]))
        if modes.general:
            return self._laws.has_failed
        return modes.mode is not Mode.SUSPENDED and self._laws.is_refuted and self._replaces_filter

    def choose(self, tracker: Tracker, modes: ModeMachine, step_ns: int) -> None:
        """Choose what is published after a step at `step_ns`: in mode GENERAL the bank, else where both differ."""
        elapsed = min((step_ns - self._chosen_ns) * 1e-9, MAX_PREDICTION_TIME)  # one sample after a gap decides nothing
        self._chosen_ns = step_ns
        self.publishes_bank = modes.general
        if self._laws is None or modes.general or modes.suspended or not self._laws.is_comparable:
            return
        predict_output(tracker.state, tracker.reference, 0.0, 0.0, self._prediction)
        another = 1.0 - self._laws.bank.exponential_probability
        self._comparison.add(elapsed, self._prediction, self.impedance, another)
        self.publishes_bank = self._replaces_filter

    @property
    def _replaces_filter(self) -> bool:
        """Whether filter and bank are inconsistent, or the filter has no valid stiffness under an improbable law."""
        improbable = self._laws is not None and self._laws.bank.exponential_probability < REJECTION
        return self._comparison.exceeds_threshold or (improbable and not self._comparison.filter_valid)

    @property
    def discrepancies(self) -> tuple[float, float]:
        """Variances of the filter's ln stiffness and damping [N^2 s^2/m^2] by the choice of the law."""
        return self._comparison.discrepancies

    def coefficients(self, tracker: Tracker) -> Coefficients:
        """Published coefficients; k2 of the bank is the local slope of ln sigma, d2 is not defined there."""
        if self.publishes_bank:
            now = self.impedance[0]
            return (
                float(now["slope"]), float(now["slope_variance"]), 0.0, 0.0, float(now["level"]), float(now["coulomb"])
            )  # fmt: skip
        known = tracker.uncertainty
        return known.k2, known.k2_variance, known.d2, known.d2_variance, known.force_offset, known.coulomb_friction


def with_bank(state: State, laws: LawChoice) -> State:
    """The state of the filter with the bank's impedance in place of the coefficients of the exponential law.

    ln stiffness and k2 are those at the present deflection, which is the reference; d1 is the damping at rest.
    """
    now = {name: float(laws.impedance[0][name]) for name in SCALARS}
    elastic = laws.elastic_law()
    relative = math.sqrt(now["slope_variance"]) / max(abs(now["slope"]), 1e-9)
    return state._replace(
        deflection_reference=state.deflection,
        ln_stiffness_reference=now["ln_stiffness"],
        ln_stiffness_reference_variance=now["ln_stiffness_variance"],
        ln_stiffness_reference_valid=now["ln_stiffness_variance"] < MAX_STIFFNESS_STD**2,
        k2=now["slope"], k2_variance=now["slope_variance"], k2_valid=state.k2_valid and relative < MAX_K2_STD,
        d1=now["rest_damping"], d1_valid=False, d2=0.0, d2_variance=0.0, d2_valid=False,
        inertia_valid=False, force_offset=now["level"], force_offset_valid=False,
        coulomb_friction=now["coulomb"], coulomb_friction_valid=False,
        observability=(f"law: {laws.description}; k2 is the local slope of ln stiffness", *state.observability),
        **(elastic.fields(state.elastic_law_valid) if elastic else {}),
    )  # fmt: skip
