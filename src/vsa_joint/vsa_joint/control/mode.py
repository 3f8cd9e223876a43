# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Operating mode of the stiffness controller: states, events and the only transition table."""

from enum import IntEnum, auto

from vsa_joint.tuning import RECOVERY_NS

Positions = tuple[float, float]  # of both motors [rad]


class Mode(IntEnum):
    """Operating mode; its lower-case name is the diagnostic value."""

    IDLE = 0  # before the first accepted command: no motor commands
    ACTIVE = 1  # feed-forward by the live law, feedback by the live estimate
    HOLDING = 2  # constant motor positions
    FEED_FORWARD = 3  # stiffness invalid or late: the last valid law without feedback
    EXCITING = 4  # stiffness invalid: co-contraction about the present state, until it is valid again


class Event(IntEnum):
    """Result of the input checks in one control period."""

    FAULT = auto()  # no control possible
    VALID = auto()  # the stiffness is valid
    TOLERABLE = auto()  # stiffness invalid without a sensor fault, or late; the last valid law is within its tolerance
    INVALID = auto()  # likewise, and the last valid law is beyond its tolerance


TRANSITIONS = {
    (Mode.IDLE, Event.FAULT): Mode.HOLDING,
    (Mode.IDLE, Event.VALID): Mode.ACTIVE,
    (Mode.IDLE, Event.TOLERABLE): Mode.FEED_FORWARD,
    (Mode.IDLE, Event.INVALID): Mode.EXCITING,
    (Mode.ACTIVE, Event.FAULT): Mode.HOLDING,
    (Mode.ACTIVE, Event.VALID): Mode.ACTIVE,
    (Mode.ACTIVE, Event.TOLERABLE): Mode.FEED_FORWARD,
    (Mode.ACTIVE, Event.INVALID): Mode.EXCITING,
    (Mode.HOLDING, Event.FAULT): Mode.HOLDING,
    (Mode.HOLDING, Event.VALID): Mode.ACTIVE,
    (Mode.HOLDING, Event.TOLERABLE): Mode.FEED_FORWARD,
    (Mode.HOLDING, Event.INVALID): Mode.EXCITING,
    (Mode.FEED_FORWARD, Event.FAULT): Mode.HOLDING,
    (Mode.FEED_FORWARD, Event.VALID): Mode.ACTIVE,
    (Mode.FEED_FORWARD, Event.TOLERABLE): Mode.FEED_FORWARD,
    (Mode.FEED_FORWARD, Event.INVALID): Mode.EXCITING,
    (Mode.EXCITING, Event.FAULT): Mode.HOLDING,
    (Mode.EXCITING, Event.VALID): Mode.ACTIVE,
    (Mode.EXCITING, Event.TOLERABLE): Mode.EXCITING,  # a command that the law predicts better does not end it
    (Mode.EXCITING, Event.INVALID): Mode.EXCITING,
}


class OperatingMode:
    """The current mode with its begin and the held positions; `handle` makes the only transitions."""

    def __init__(self) -> None:
        self._mode = Mode.IDLE
        self._since_ns: int | None = None
        self._held: Positions | None = None
        self._held_since_ns = 0
        self._recovery_ns = 0  # healthy time that a hold still needs
        self._checked_ns = 0  # of the last check in a hold
        self._was_faulty = False  # at that check

    @property
    def mode(self) -> Mode:
        """The current mode."""
        return self._mode

    @property
    def held(self) -> Positions | None:
        """Positions of the current or last hold; None before the first, or without a measured position."""
        return self._held

    def duration(self, now_ns: int) -> float:
        """Time in the current mode [s]; 0 before the first change."""
        return 0.0 if self._since_ns is None else (now_ns - self._since_ns) * 1e-9

    def handle(self, event: Event, positions: Positions | None, now_ns: int) -> bool:
        """Change the mode; whether it has changed.

        A hold keeps its first `positions`. It ends as soon as the inputs were healthy for as long as they were faulty
        in it; of a fault RECOVERY_NS count at most, and another fault adds its duration only.
        """
        faulty = event is Event.FAULT
        if self._mode is Mode.HOLDING:
            self._update_recovery(faulty, now_ns)
            if not faulty and self._recovery_ns > 0:
                return False
        elif faulty:
            self._held, self._recovery_ns, self._checked_ns, self._was_faulty = None, 0, now_ns, True
        if faulty and self._held is None:
            self._held, self._held_since_ns = positions, now_ns
        before, self._mode = self._mode, TRANSITIONS[self._mode, event]
        if self._mode is before:
            return False
        self._since_ns = now_ns
        return True

    def needs_engagement(self, now_ns: int) -> bool:
        """Whether the control state is outdated: before the first activation, or in a hold beyond RECOVERY_NS."""
        if self._mode is Mode.HOLDING:
            return now_ns - self._held_since_ns > RECOVERY_NS
        return self._mode is Mode.IDLE

    def _update_recovery(self, faulty: bool, now_ns: int) -> None:
        """Add the time since the last check to the recovery after a fault, subtract it after healthy inputs."""
        elapsed = now_ns - self._checked_ns
        self._recovery_ns = min(max(self._recovery_ns + (elapsed if self._was_faulty else -elapsed), 0), RECOVERY_NS)
        self._checked_ns, self._was_faulty = now_ns, faulty
