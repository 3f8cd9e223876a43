# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The bank beside the filter of the exponential law, and the evidence against that law."""

import math

from vsa_estimator.general.bank import Bank
from vsa_estimator.general.records import Record
from vsa_estimator.settings import Initial
from vsa_estimator.tuning.filter import NIS_CAP, NIS_THRESHOLD
from vsa_estimator.tuning.force_law import MIN_K2
from vsa_estimator.tuning.general import (
    ADEQUACY_TIME,
    CONFIRMATION,
    CONFIRMATION_TIME,
    DISAGREEMENT,
    MIN_AGE,
    REFUTATION,
    REFUTATION_TIME,
)


class LawSelection:
    """The bank of laws of one transmission.

    The exponential law is a member, so that its likelihood has the motion model of the others. It is refuted where it
    stays near MAX_EVIDENCE below the best member for REFUTATION_TIME, while the bank explains the force. It is
    confirmed where its probability stays above CONFIRMATION for CONFIRMATION_TIME: what departs from it later is a
    fault or a changed transmission. Either ends the comparison.
    """

    def __init__(self, initial: Initial, rate: float) -> None:
        """`initial` coefficients; `rate` of the filter [Hz]."""
        self.bank = Bank(initial, rate)
        self.restart()

    def restart(self) -> None:
        """Drop all data."""
        self.bank.restart()
        self._step_ns = 0
        self._interrupted = False  # the motion has a gap before the next step
        self._refuted_for = self._confirmed_for = self._inadequate_for = 0.0  # [s]
        self.is_confirmed = False  # whether the exponential law holds
        self._mean_nis = 1.0  # of the force in the most probable member

    def interrupt(self) -> None:
        """The motion has a gap before the next step."""
        self._interrupted = True

    def shift(self, offset: float) -> None:
        """The encoder reads `offset` [m] more from now on."""
        self.bank.shift(offset)
        self._interrupted = True

    def step(
        self, stamp_ns: int, deflection: tuple[float, float], force: tuple[float, float], k2: float | None
    ) -> None:
        """One step at a stamp [ns] with `deflection` [m] and `force` [N], each with its variance.

        A force of NaN is none. `k2` [1/m] is the estimate of the filter, None where it has none.
        """
        if self.is_confirmed:
            return
        dt = (stamp_ns - self._step_ns) * 1e-9
        self._step_ns = stamp_ns
        if self._interrupted:
            self._interrupted = False
            self.bank.interrupt(*deflection)
            return
        growth = max(k2 if k2 is not None else float(self.impedance["slope"][0]), MIN_K2)
        self.bank.step(dt, deflection, force, growth)
        nis = self.bank.force_nis
        if nis is not None:
            self._mean_nis += min(dt / ADEQUACY_TIME, 1.0) * (min(nis, NIS_CAP) - self._mean_nis)
        refuted = self.bank.exponential_evidence < -REFUTATION and self.bank.age > MIN_AGE and self.is_adequate
        self._refuted_for = self._refuted_for + dt if refuted else 0.0
        certain = self.bank.exponential_probability > CONFIRMATION and self.bank.age > MIN_AGE and self.is_adequate
        self._confirmed_for = self._confirmed_for + dt if certain else 0.0
        self.is_confirmed = k2 is not None and self._confirmed_for > CONFIRMATION_TIME
        self._inadequate_for = 0.0 if self.is_adequate else self._inadequate_for + dt

    @property
    def is_refuted(self) -> bool:
        """Whether the exponential law is refuted."""
        return self._refuted_for > REFUTATION_TIME and not self.bank.is_repeating

    @property
    def is_adequate(self) -> bool:
        """Whether the most probable member explains the recent forces."""
        return self._mean_nis < NIS_THRESHOLD

    def is_preferred(self, exponential: Record) -> bool:
        """Whether the mixture is a better estimate than that of the filter of the exponential law, (1,) PREDICTION.

        It is where the exponential law has less than half of the probability, and where stiffness or damping of both
        differ significantly.
        """
        if self.is_confirmed or self.bank.age < MIN_AGE or not self.is_adequate:
            return False
        if self.bank.exponential_probability < 0.5:
            return True
        bank, one = self.impedance[0], exponential[0]
        error = float(bank["ln_stiffness"]) - math.log(max(float(one["stiffness"]), 1e-9))
        variance = float(bank["ln_stiffness_variance"]) + float(one["ln_stiffness_variance"])
        if error * error > DISAGREEMENT * variance:
            return True
        error = float(bank["damping"] - one["damping"])
        variance = float(bank["damping_variance"] + one["damping_variance"])
        return error * error > DISAGREEMENT * variance

    @property
    def has_failed(self) -> bool:
        """Whether no member has explained the forces for REFUTATION_TIME."""
        return self._inadequate_for > REFUTATION_TIME

    @property
    def impedance(self) -> Record:
        """(1,) IMPEDANCE of the mixture."""
        return self.bank.impedance
