# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Operating mode of the estimator of one transmission: the modes, the events, and the one table of transitions."""

from enum import Enum, IntEnum, auto


class Mode(IntEnum):
    """What the estimates come from; the numbers are those of EstimatorState.msg."""

    WAITING = 0  # no sample yet
    INITIALIZING = 1  # coefficients from regressions, motion from the encoder alone
    TRACKING = 2  # the filter estimates motion and coefficients
    SUSPENDED = 3  # coefficients are held: force and encoder are not known to be consistent
    GENERAL = 4  # the exponential law is refuted: the bank of the general transmission estimates
    GENERAL_SUSPENDED = 5  # the bank is held, as the coefficients in SUSPENDED


class Event(Enum):
    """What changes the mode."""

    FIRST_SAMPLE = auto()
    HAND_OVER = auto()  # two successive regressions are accurate enough for the filter's linearisation
    INCONSISTENT = auto()  # a parity residual, an encoder step, a gap, or a failed NIS test
    CONSISTENT = auto()  # parity residuals of both sensors are within their limits again
    REJECTED = auto()  # no sensor shift explains the inconsistency: the coefficients are given up
    REFUTED = auto()  # the filter is inconsistent, and another law explains the forces


TRANSITIONS: dict[tuple[Mode, Event], Mode] = {
    (Mode.WAITING, Event.FIRST_SAMPLE): Mode.INITIALIZING,
    (Mode.INITIALIZING, Event.HAND_OVER): Mode.TRACKING,
    (Mode.TRACKING, Event.INCONSISTENT): Mode.SUSPENDED,
    (Mode.SUSPENDED, Event.INCONSISTENT): Mode.SUSPENDED,
    (Mode.SUSPENDED, Event.CONSISTENT): Mode.TRACKING,
    (Mode.TRACKING, Event.REJECTED): Mode.INITIALIZING,
    (Mode.SUSPENDED, Event.REJECTED): Mode.INITIALIZING,
    (Mode.INITIALIZING, Event.REFUTED): Mode.GENERAL,
    (Mode.TRACKING, Event.REFUTED): Mode.GENERAL,
    (Mode.GENERAL, Event.INCONSISTENT): Mode.GENERAL_SUSPENDED,
    (Mode.GENERAL_SUSPENDED, Event.INCONSISTENT): Mode.GENERAL_SUSPENDED,
    (Mode.GENERAL_SUSPENDED, Event.CONSISTENT): Mode.GENERAL,
    (Mode.GENERAL, Event.REJECTED): Mode.INITIALIZING,
    (Mode.GENERAL_SUSPENDED, Event.REJECTED): Mode.INITIALIZING,
}


class ModeMachine:
    """Owner of the operating mode; only `handle` changes it.

    Plain attributes, since every filter step reads them: `mode`; `initialized`, whether the filter has taken over the
    coefficients; `suspended`; `general`, whether the bank estimates; `reason`, why updates are suspended, empty in any
    other mode.
    """

    def __init__(self) -> None:
        """No sample yet."""
        self._enter(Mode.WAITING, "")

    def handle(self, event: Event, reason: str = "") -> None:
        """Change the mode. Raises KeyError for an event that the table does not have in this mode."""
        self._enter(TRANSITIONS[self.mode, event], reason)

    def _enter(self, mode: Mode, reason: str) -> None:
        self.mode = mode
        self.general = mode in (Mode.GENERAL, Mode.GENERAL_SUSPENDED)
        self.suspended = mode in (Mode.SUSPENDED, Mode.GENERAL_SUSPENDED)
        self.initialized = self.general or mode in (Mode.TRACKING, Mode.SUSPENDED)
        self.reason = reason if self.suspended else ""
