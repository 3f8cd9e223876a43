# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Choice between the filter of the exponential law and the bank of laws: what is published, and the mode."""

import copy
import math
from collections import deque
from typing import NamedTuple

import numpy as np
from vsa_common.accel import ACCELERATED
from vsa_estimator.fault_detection.held_law import HeldLaw
from vsa_estimator.fault_detection.isolation import SensorShift
from vsa_estimator.filter.output_prediction import predict_output
from vsa_estimator.filter.records import PREDICTION
from vsa_estimator.filter.tracker import Tracker
from vsa_estimator.general.bank import Bank
from vsa_estimator.general.records import IMPEDANCE, Record
from vsa_estimator.law_comparison import LawComparison, move_to
from vsa_estimator.law_selection import LawSelection
from vsa_estimator.modes import Mode, ModeMachine
from vsa_estimator.preprocessing.decimator import Decimated
from vsa_estimator.settings import EstimatorConfig
from vsa_estimator.tuning.fault_detection import CHECKPOINT_PERIOD
from vsa_estimator.tuning.general import ACCEPTANCE, REJECTION
from vsa_estimator.tuning.output import MAX_PREDICTION_TIME, MAX_STIFFNESS_STD

NO_IMPEDANCE = np.zeros(1, IMPEDANCE)


class Checkpoint(NamedTuple):
    """Bank and comparison while filter and bank were consistent."""

    laws: LawSelection
    comparison: LawComparison


class LawChoice:
    """The bank of laws beside the filter; none where the law is fixed, and in plain Python, which is too slow."""

    def __init__(self, config: EstimatorConfig) -> None:
        """Before the first step."""
        automatic = config.elastic_law == "automatic" and ACCELERATED
        self._laws = LawSelection(config.initial, config.filter_rate) if automatic else None
        self._comparison, self._prediction = LawComparison(), np.zeros(1, PREDICTION)
        self._moved = np.zeros(1, IMPEDANCE)  # of the bank, at the motion of the filter
        self._checkpoints: deque[Checkpoint] = deque(maxlen=2)
        self._chosen_ns = self._kept_ns = 0
        self._replaced_share = 0.0  # leaky share of the time in which the bank replaced the filter
        self.is_held = self._slice_due = False  # is_held: like the filter's coefficients
        self._repetitions, self._compared_age = 0, 0.0  # of the bank at the last comparison
        self.publishes_bank = False  # its stiffness and damping
        self.replaces_filter = False  # the bank, which is inconsistent with the filter: its coefficients, too
        self.discrepancies = (0.0, 0.0)  # variances of the filter's ln stiffness and damping by the choice of the law

    @property
    def is_slice_due(self) -> bool:
        """Whether the bank has a part of a repetition to do before the next step: one for each step."""
        return self._slice_due and self._laws is not None and self._laws.bank.is_repeating

    @property
    def explains_inconsistency(self) -> bool:
        """Whether an inconsistency of the filter's coefficients is one of their law, and no fault since the checkpoint.

        The bank replaced the filter for most of a checkpoint's greatest age, and explains the forces; in a part of the
        stroke that is new to it, its stiffness need not be valid.
        """
        return self._laws is not None and self._laws.is_adequate and self._replaced_share > ACCEPTANCE

    @property
    def is_rich(self) -> bool:
        """Whether the bank has had a motion that is rich enough for a decision between the laws, and is not held."""
        return self._laws is not None and self._laws.is_rich and not (self._laws.is_confirmed or self.is_held)

    @property
    def impedance(self) -> Record:
        """(1,) IMPEDANCE of the bank; zero without one."""
        return self._laws.impedance if self._laws is not None else NO_IMPEDANCE

    @property
    def published_impedance(self) -> Record:
        """(1,) IMPEDANCE that is published where the bank is; at the filter's motion unless the bank has its own."""
        return self.impedance if self.replaces_filter and not self.is_held else self._moved

    @property
    def description(self) -> str:
        """The bank's most probable model, where it replaces the filter; else empty."""
        return self._laws.bank.description if self._laws is not None and self.replaces_filter else ""

    @property
    def bank(self) -> Bank | None:
        """The bank; None where the law is fixed."""
        return self._laws.bank if self._laws is not None else None

    def repeat_slice(self) -> bool:
        """Do the part of a repetition that is due; whether the repetition is complete."""
        due, self._slice_due = self.is_slice_due, False
        if not due or self._laws is None:
            return False
        self._laws.bank.repeat_slice()
        return not self._laws.bank.is_repeating

    def restart(self) -> None:
        """Drop the data: the position is no longer valid."""
        self._checkpoints.clear()
        self.is_held = self.publishes_bank = self.replaces_filter = False
        self.discrepancies = (0.0, 0.0)
        self._replaced_share = 0.0
        if self._laws is not None:
            self._laws.restart()
            self._comparison.restart()

    def confirm(self) -> None:
        """The exponential law holds, by a previous run."""
        if self._laws is not None:
            self._laws.is_confirmed = True

    def hold(self, general: bool) -> None:
        """The filter's coefficients are held: so are those of the bank, if the exponential law was consistent before.

        A fault or a change must not be explained: the bank returns to its checkpoint. In mode `general` it stays.
        """
        self.is_held |= general
        if self.is_held or not self._checkpoints or self._laws is None:
            return
        self.is_held = True
        present, (self._laws, self._comparison) = self._laws, self._checkpoints[0]
        self._laws.continue_from(present)
        self._replace_checkpoints()

    def hold_at(self, checkpoint: LawSelection) -> None:
        """Hold the bank in mode GENERAL, with the coefficients of a checkpoint."""
        if self._laws is not None:
            present, self._laws = self._laws, checkpoint.copied()
            self._laws.continue_from(present)
            self.is_held = True

    def held(self) -> HeldLaw:
        """The present bank as a checkpoint of the parity check."""
        assert self._laws is not None
        return HeldLaw(self._laws.copied())

    def reject(self) -> None:
        """The filter's coefficients are given up; the bank drops its data unless it explains the force.

        A law that is confirmed keeps its form: its coefficients are estimated again.
        """
        if self._laws is not None and not self._laws.is_confirmed and (self.is_held or not self._laws.is_adequate):
            self.restart()

    def refute(self) -> None:
        """The exponential law is refuted: it has no part in the mixture any more."""
        if self._laws is not None:
            self._laws.bank.exclude_exponential()

    def interrupt(self) -> None:
        """The motion has a gap before the next step."""
        if self._laws is not None:
            self._laws.interrupt()

    def shift(self, shift: SensorShift) -> None:
        """A sensor reads this much more from now on."""
        if self._laws is not None:
            self._laws.shift(shift.deflection, shift.force, shift.variances)
            if self._checkpoints:
                self._replace_checkpoints()

    def step(self, block: Decimated, noise: tuple[float, float], modes: ModeMachine) -> bool:
        """Step the bank by a block with the variances `noise` of deflection [m^2] and force [N^2].

        Whether the operating mode has to change: the exponential law is refuted and the filter inconsistent with the
        bank, or in mode GENERAL no law explains the force.
        """
        if self._laws is None:
            return False
        self.is_held &= modes.suspended
        if self.is_held:
            self._laws.follow(block.stamp_ns, block.deflection)
            return False
        self._slice_due = True
        force = block.force if block.forces else math.nan
        self._laws.step(block.stamp_ns, (block.deflection, noise[0]), (force, noise[1]))
        if modes.general:
            return self._laws.has_failed
        return modes.mode is not Mode.SUSPENDED and self._laws.is_refuted and self._is_inconsistent

    def choose(self, tracker: Tracker, modes: ModeMachine, step_ns: int) -> None:
        """Choose what is published after a step at `step_ns`: the bank in mode GENERAL, and by comparison."""
        elapsed = min((step_ns - self._chosen_ns) * 1e-9, MAX_PREDICTION_TIME)  # one sample after a gap decides nothing
        self._chosen_ns = step_ns
        self.publishes_bank = self.replaces_filter = modes.general
        self.discrepancies = (0.0, 0.0)
        laws = self._laws
        if modes.general and self.is_held:
            predict_output(tracker.state, tracker.reference, 0.0, 0.0, self._prediction)
            self._move(tracker)
        if laws is None or laws.is_confirmed or modes.mode not in (Mode.INITIALIZING, Mode.TRACKING):
            return
        if laws.bank.age > 0.0:
            self._compare(laws, tracker)
            replaced = 1.0 if self.replaces_filter else 0.0
            self._replaced_share += elapsed / (2.0 * CHECKPOINT_PERIOD) * (replaced - self._replaced_share)
        if self.replaces_filter:
            self._checkpoints.clear()
        elif modes.initialized and step_ns - self._kept_ns > CHECKPOINT_PERIOD * 1e9:
            probable = laws.bank.exponential_probability > ACCEPTANCE  # decides before they are compared
            if not self._is_inconsistent if laws.is_comparable else probable:
                self._keep(step_ns)

    def _compare(self, laws: LawSelection, tracker: Tracker) -> None:
        """Compare filter and bank, and choose. The means begin with a rich motion, and stand still without evidence."""
        comparison, another = self._comparison, 1.0 - laws.bank.exponential_probability
        elapsed, self._compared_age = max(laws.bank.age - self._compared_age, 0.0), laws.bank.age
        if laws.bank.repetitions != self._repetitions:
            self._repetitions = laws.bank.repetitions
            comparison.restart_test()
        predict_output(tracker.state, tracker.reference, 0.0, 0.0, self._prediction)
        comparison.add(elapsed if laws.is_rich else 0.0, self._prediction, self.impedance, another)
        self.replaces_filter = laws.is_comparable and self._is_inconsistent
        valid = float(self.impedance["ln_stiffness_variance"][0]) < MAX_STIFFNESS_STD**2
        self.publishes_bank = self.replaces_filter or (laws.prefers_another_spring and valid)
        if self.replaces_filter:
            return
        self.discrepancies = comparison.discrepancies(self.impedance, another, laws.is_improbable)
        if self.publishes_bank:
            self._move(tracker)

    def _move(self, tracker: Tracker) -> None:
        """Compute the bank's impedance at the motion of the filter, whose prediction is new."""
        self._moved[:] = self.impedance
        move_to(self._prediction, tracker.p[:3, :3], self._moved)

    def _keep(self, step_ns: int) -> None:
        if self._laws is not None and not self._laws.bank.is_repeating:
            self._kept_ns = step_ns
            self._checkpoints.append(Checkpoint(self._laws.copied(), copy.deepcopy(self._comparison)))

    def _replace_checkpoints(self) -> None:
        """The present bank is the only checkpoint."""
        self._checkpoints.clear()
        self._keep(self._kept_ns)

    @property
    def _is_inconsistent(self) -> bool:
        """Whether filter and bank are inconsistent, or the filter has no valid stiffness under an improbable law."""
        improbable = self._laws is not None and self._laws.bank.exponential_probability < REJECTION
        return self._comparison.exceeds_threshold or (improbable and not self._comparison.filter_valid)
