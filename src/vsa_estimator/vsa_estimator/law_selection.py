# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The bank beside the filter of the exponential law, and the evidence against that law."""

import copy
import math

from vsa_estimator.general.bank import Bank
from vsa_estimator.general.records import Record
from vsa_estimator.settings import Initial
from vsa_estimator.tuning.filter import NIS_CAP, NIS_THRESHOLD
from vsa_estimator.tuning.general import (
    ADEQUACY_TIME,
    MAX_INERTIA,
    MIN_AGE,
    MIN_TURNS,
    REFUTATION,
    REFUTATION_TIME,
    TURN_STDS,
    TURN_TRAVEL,
)


class Reversals:
    """Reversals of the motion, each after a travel over which the stiffness changes by 10 %."""

    def __init__(self, travel: float) -> None:
        """`travel` [m] that is too long for a reversal of noise."""
        self._travel = travel
        self.count, self._direction, self._extreme = 0, 1, -math.inf

    def add(self, deflection: float, variance: float) -> None:
        """Add a deflection [m] with this variance [m^2]; the noise of the encoder is no reversal."""
        if self._direction * (deflection - self._extreme) >= 0.0:
            self._extreme = deflection
        elif abs(deflection - self._extreme) > max(self._travel, TURN_STDS * math.sqrt(variance)):
            self.count += 1
            self._direction, self._extreme = -self._direction, deflection

    def shift(self, offset: float) -> None:
        """The encoder reads `offset` [m] more from now on."""
        self._extreme += offset


class LawSelection:
    """The bank of laws of one transmission.

    The exponential law is a member, so that its likelihood has the motion model of the others. It is refuted where it
    stays near MAX_EVIDENCE below the best member for REFUTATION_TIME, while the bank explains the force. A law that is
    confirmed by a previous run ends the comparison: what departs from it is a fault.
    """

    def __init__(self, initial: Initial, rate: float) -> None:
        """`initial` coefficients; `rate` of the filter [Hz]."""
        self.bank, self._turn_travel = Bank(initial, rate), TURN_TRAVEL / initial.k2
        self.is_confirmed = False  # whether the exponential law holds
        self.restart()

    def restart(self) -> None:
        """Drop all data."""
        self.bank.restart()
        self._reversals = Reversals(self._turn_travel)
        self._step_ns = 0
        self._interrupted = False  # the motion has a gap before the next step
        self._shift = (0.0, 0.0)  # variances of a shift of encoder [m^2] and force sensor [N^2] in it
        self._refuted_for = self._inadequate_for = 0.0  # [s]
        self._another_spring = False  # whether the evidence is against an exponential spring
        self._another_law = False  # whether it is against the exponential law
        self._mean_nis = 1.0  # of the force in the most probable member

    def interrupt(self) -> None:
        """The motion has a gap before the next step."""
        self._interrupted = True

    def follow(self, stamp_ns: int, deflection: float) -> None:
        """Follow the motion to a deflection [m] at a stamp [ns] without an update; the next step is after a gap."""
        self.bank.follow((stamp_ns - self._step_ns) * 1e-9, deflection)
        self._step_ns, self._interrupted = stamp_ns, True

    def continue_from(self, present: "LawSelection") -> None:
        """Go on with the coefficients of this selection, a checkpoint, at the time of the `present` one."""
        self.bank.take_memory(present.bank)
        self._step_ns, self._interrupted = present._step_ns, True

    def copied(self) -> "LawSelection":
        """The selection as it is, without a running repetition."""
        other = copy.copy(self)
        other.bank, other._reversals = self.bank.copied(), copy.copy(self._reversals)
        return other

    def shift(self, deflection: float, force: float, variances: tuple[float, float]) -> None:
        """Encoder and force sensor read `deflection` [m] and `force` [N] more from now on, with these variances."""
        self.bank.shift(deflection, force)
        self._reversals.shift(deflection)
        self._interrupted, self._shift = True, (self._shift[0] + variances[0], self._shift[1] + variances[1])

    def step(self, stamp_ns: int, deflection: tuple[float, float], force: tuple[float, float]) -> None:
        """One step at a stamp [ns]; `deflection` [m] and `force` [N] with their variances; a force of NaN is none."""
        if self.is_confirmed:
            return
        dt = (stamp_ns - self._step_ns) * 1e-9
        self._step_ns = stamp_ns
        if self._interrupted:
            self.bank.interrupt(dt, deflection, self._shift)
            self._interrupted, self._shift = False, (0.0, 0.0)
            return
        self.bank.step(dt, deflection, force)
        self._reversals.add(*deflection)
        nis = self.bank.force_nis
        if nis is not None:
            self._mean_nis += min(dt / ADEQUACY_TIME, 1.0) * (min(nis, NIS_CAP) - self._mean_nis)
        self._another_spring = self.bank.exponential_spring_evidence < -_limit(self._another_spring)
        self._another_law = self.bank.repetitions > 0 and self.bank.exponential_evidence < -_limit(self._another_law)
        refuted = self.is_improbable and self.is_rich and self.is_adequate
        self._refuted_for = self._refuted_for + dt if refuted else 0.0
        self._inadequate_for = 0.0 if self.is_adequate else self._inadequate_for + dt

    @property
    def time(self) -> float:
        """Stamp of the last step [s]."""
        return self._step_ns * 1e-9

    @property
    def is_rich(self) -> bool:
        """Whether the motion was long and varied enough for a decision between the laws."""
        return self.bank.age > MIN_AGE and self._reversals.count >= MIN_TURNS

    @property
    def is_improbable(self) -> bool:
        """Whether the present evidence is against the exponential law; none counts before a repetition."""
        return self.bank.repetitions > 0 and self.bank.exponential_evidence < -REFUTATION

    @property
    def is_refuted(self) -> bool:
        """Whether the exponential law is refuted."""
        return self._refuted_for > REFUTATION_TIME and not self.bank.is_repeating

    @property
    def is_adequate(self) -> bool:
        """Whether the most probable member explains the recent forces, and the mixture by a mass within its scope.

        In a single tone a larger mass and a stiffer spring explain the same force.
        """
        return self._mean_nis < NIS_THRESHOLD and float(self.impedance["inertia"][0]) < MAX_INERTIA

    @property
    def is_comparable(self) -> bool:
        """Whether the mixture can be compared with the filter: by a motion that is rich enough, and adequate."""
        return self.is_rich and self.is_adequate and not self.is_confirmed

    @property
    def prefers_another_spring(self) -> bool:
        """Whether the evidence is against an exponential spring with any damper; with a hysteresis of its half."""
        return self._another_spring and self.is_comparable

    @property
    def prefers_another_law(self) -> bool:
        """Whether the evidence is against the exponential law; with a hysteresis of its half."""
        return self._another_law and self.is_comparable

    @property
    def has_failed(self) -> bool:
        """Whether no member has explained the forces for REFUTATION_TIME."""
        return self._inadequate_for > REFUTATION_TIME

    @property
    def impedance(self) -> Record:
        """(1,) IMPEDANCE of the mixture."""
        return self.bank.impedance


def _limit(preferred: bool) -> float:
    """Evidence for another law above which it is preferred, or stays so."""
    return 0.5 * REFUTATION if preferred else REFUTATION
