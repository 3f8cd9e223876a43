# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Operating mode of the stiffness controller: states, events and the only transition table."""

from enum import IntEnum, auto

from vsa_joint.tuning import RECOVERY_NS, SHORT_HOLD_NS

Positions = tuple[float, float]  # of both motors [rad]


class Mode(IntEnum):
    """Operating mode; its lower-case name is the diagnostic value."""

    IDLE = 0  # before the first accepted command: no motor commands
    ACTIVE = 1
    HOLDING = 2  # constant motor positions


class Event(IntEnum):
    """Result of the input checks in one control period."""

    FAULT = auto()
    RECOVERED = auto()  # healthy for the required duration


TRANSITIONS = {
    (Mode.IDLE, Event.FAULT): Mode.HOLDING,
    (Mode.IDLE, Event.RECOVERED): Mode.ACTIVE,
    (Mode.ACTIVE, Event.FAULT): Mode.HOLDING,
    (Mode.ACTIVE, Event.RECOVERED): Mode.ACTIVE,
    (Mode.HOLDING, Event.FAULT): Mode.HOLDING,
    (Mode.HOLDING, Event.RECOVERED): Mode.ACTIVE,
}


class OperatingMode:
    """The current mode with the held positions; `hold` and `resume` are the only transitions."""

    def __init__(self) -> None:
        self._mode = Mode.IDLE
        self._held: Positions | None = None
        self._held_since_ns = 0
        self._healthy_since_ns: int | None = None

    @property
    def mode(self) -> Mode:
        """The current mode."""
        return self._mode

    @property
    def held(self) -> Positions | None:
        """Positions of the current or last hold; None before the first, or without a measured position."""
        return self._held

    def hold(self, positions: Positions | None, now_ns: int) -> None:
        """Fault: hold `positions`, or continue the present hold."""
        if self._mode is not Mode.HOLDING or self._held is None:
            self._held, self._held_since_ns = positions, now_ns
        self._healthy_since_ns = None
        self._mode = TRANSITIONS[self._mode, Event.FAULT]

    def resume(self, now_ns: int) -> bool:
        """Healthy inputs: become ACTIVE as soon as they are healthy long enough. Whether the mode is ACTIVE.

        After a hold of at most SHORT_HOLD_NS they must be healthy for as long as the hold, else for RECOVERY_NS.
        """
        if self._mode is Mode.HOLDING:
            if self._healthy_since_ns is None:
                self._healthy_since_ns = now_ns
            held_ns = self._healthy_since_ns - self._held_since_ns
            if now_ns - self._healthy_since_ns < (held_ns if held_ns <= SHORT_HOLD_NS else RECOVERY_NS):
                return False
        self._mode = TRANSITIONS[self._mode, Event.RECOVERED]
        return True

    def needs_engagement(self, now_ns: int) -> bool:
        """Whether the control state is outdated: before the first activation, or after a hold beyond RECOVERY_NS."""
        return self._mode is Mode.IDLE or now_ns - self._held_since_ns > RECOVERY_NS
