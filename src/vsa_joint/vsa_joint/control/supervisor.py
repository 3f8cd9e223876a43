"""When stiffness control may work, and what happens when it may not: the motors hold, and the reason is told.

Instants are of a steady clock and come in as arguments.
"""

import math
from dataclasses import dataclass, field
from enum import Enum

from vsa_common.types import Status
from vsa_joint.control.controller import Judgement, Live, StiffnessControl, Target
from vsa_joint.control.springs import Spring
from vsa_joint.settings import ControlConfig

SECOND_NS = 1_000_000_000
MEASURED_TIMEOUT_NS = SECOND_NS // 10  # angle and motors come slower than the estimates
STATE_TIMEOUT_NS = SECOND_NS // 4  # an estimator's state comes at 50 Hz
AHEAD_NS = SECOND_NS // 10  # stamps further in the future are of another clock: nobody knows their age
HICCUP_NS = SECOND_NS // 10  # after a hold no longer than that, all must be well as long as it was not ...
RECOVERY_NS = SECOND_NS // 2  # ... and after a longer one for so long, before control resumes
LEAST_FORCE = 1.0  # N, a rod that feels less has a slack tendon or a sensor that is off
OVERLOAD = 1.05  # of force_max, beyond which the motors hold
FOLLOW_RAD, FOLLOW_NS = 0.3, SECOND_NS // 2  # motors further than that from their command do not follow


class Mode(Enum):
    """What the controller does."""

    IDLE = "idle"  # no command yet: says nothing to the motors
    ACTIVE = "active"
    HOLDING = "holding"


@dataclass(frozen=True)
class JointMeasurement:
    """What the controller needs of a JointImpedance."""

    stiffness: float
    stiffness_valid: bool
    damping: float
    damping_valid: bool
    tension: tuple[float, float]
    force_valid: bool
    status: int
    reason: str


@dataclass
class Inputs:
    """The newest of everything, each with the instant of its arrival [ns].

    `measured_ns` has the instants of their stamps by topic, so that a backlog does not pass as fresh.
    """

    joint: JointMeasurement | None = None
    joint_ns: int = 0
    angle: float = math.nan
    angle_ns: int = 0
    motors: tuple[float, float] | None = None
    motors_ns: int = 0
    springs: tuple[Spring | None, Spring | None] = (None, None)
    springs_ns: tuple[int, int] = (0, 0)
    complaints: tuple[str, str] = ("", "")  # of the estimators
    measured_ns: dict[str, int] = field(default_factory=dict)


class Supervisor:
    """Takes commands, watches the inputs, steps the control, or holds."""

    def __init__(self, config: ControlConfig) -> None:
        self.control = StiffnessControl(config)
        self.mode, self.reason = Mode.IDLE, "no stiffness_command yet"
        self.refused = 0
        self.judgement: Judgement | None = None
        self.target: Target | None = None
        self._timeout_ns = int(config.input_timeout * SECOND_NS)
        self._period_ns = int(SECOND_NS / config.rate)
        self._command_timeout_ns = int(config.command_timeout * SECOND_NS)
        self._command_ns = 0
        self._hold: tuple[float, float] | None = None
        self._sent: tuple[float, float] | None = None
        self._held_ns = 0
        self._well_ns: int | None = None
        self._followed_ns = 0
        self._damping = 1.0
        self._config = config
        self._seen_ns = [0, 0]  # when each tension last changed
        self._tension: tuple[float, float] = (math.nan, math.nan)

    def command(self, target: Target, inputs: Inputs, now_ns: int) -> Judgement:
        """Take or refuse a command; a refused one leaves the target as it was."""
        self._command_ns = now_ns
        fault = self._fault(inputs, now_ns)
        live = None if fault else self._live(inputs)
        if live is None:
            judgement = Judgement(False, fault or "no estimate yet", None, math.inf)
        else:
            if self.mode is Mode.IDLE:
                self.control.engage(live)
            judgement = self.control.judge(target, live)
        self.judgement = judgement
        if judgement.accepted:
            self.target = target
        elif live is not None:
            self.refused += 1
        return judgement

    def step(self, inputs: Inputs, now_ns: int) -> tuple[float, float] | None:
        """Motor positions [rad] for this period; None while nothing was ever commanded."""
        self._look_at_forces(inputs, now_ns)
        if self.target is None:
            return None
        fault = self._fault(inputs, now_ns)
        if not fault and now_ns - self._command_ns > self._command_timeout_ns:
            fault = "stiffness_command stopped"
        if not fault and self.mode is Mode.ACTIVE and not self._follows(inputs, now_ns):
            fault = "motors do not follow: is the driver armed?"
        live = self._live(inputs)
        if fault or live is None:
            return self._stop(fault or "no estimate yet", inputs, now_ns)
        if self.mode is not Mode.ACTIVE and not self._recovered(now_ns):
            return self._hold
        if self.mode is not Mode.ACTIVE:
            if self.mode is Mode.IDLE or now_ns - self._held_ns > RECOVERY_NS:
                self.control.engage(live)
            self.mode, self._followed_ns = Mode.ACTIVE, now_ns
        self.reason = self.judgement.text if self.judgement is not None else ""
        self._sent = self.control.step(self.target, live)
        return self._sent

    def _stop(self, reason: str, inputs: Inputs, now_ns: int) -> tuple[float, float] | None:
        if self.mode is not Mode.HOLDING or self._hold is None:
            self._hold, self._held_ns = inputs.motors if inputs.motors is not None else self._sent, now_ns
        self.mode, self.reason, self._well_ns = Mode.HOLDING, reason, None
        return self._hold

    def _recovered(self, now_ns: int) -> bool:
        if self.mode is Mode.IDLE:
            return True
        if self._well_ns is None:
            self._well_ns = now_ns
        held_ns = self._well_ns - self._held_ns
        return now_ns - self._well_ns >= (held_ns if held_ns <= HICCUP_NS else RECOVERY_NS)

    def _follows(self, inputs: Inputs, now_ns: int) -> bool:
        if self._sent is None or inputs.motors is None:
            return True
        if max(abs(a - b) for a, b in zip(self._sent, inputs.motors, strict=True)) < FOLLOW_RAD:
            self._followed_ns = now_ns
        return now_ns - self._followed_ns <= FOLLOW_NS

    def _fault(self, inputs: Inputs, now_ns: int) -> str:
        """Why control cannot work now; empty when it can."""
        joint = inputs.joint
        age = self._age_fault("joint_impedance", inputs.joint_ns, self._timeout_ns, inputs, now_ns)
        if joint is None or age:
            return _because(age or "joint_impedance silent", self._complaints(inputs, now_ns))
        if joint.status in (Status.STALE, Status.FAULT, Status.INITIALIZING) or not joint.stiffness_valid:
            return _because(f"joint stiffness invalid: {joint.reason or Status(joint.status).name}", inputs.complaints)
        if not joint.force_valid:
            return _because(f"tension invalid: {joint.reason or 'a force sensor is not well'}", inputs.complaints)
        age = self._age_fault("joint_states", inputs.angle_ns, MEASURED_TIMEOUT_NS, inputs, now_ns)
        if not math.isfinite(inputs.angle) or age:
            return age or "joint_states silent"
        age = self._age_fault("motor_states", inputs.motors_ns, MEASURED_TIMEOUT_NS, inputs, now_ns)
        if inputs.motors is None or age:
            return age or "motor_states silent"
        for number, spring, arrival in zip((1, 2), inputs.springs, inputs.springs_ns, strict=True):
            name = f"transmission_{number}/estimator_state"
            age = self._age_fault(name, arrival, STATE_TIMEOUT_NS, inputs, now_ns)
            if spring is None or age:
                return age or f"{name} silent"
            fault = self._force_fault(number, 2.0 * joint.tension[number - 1], spring, now_ns)
            if fault:
                return fault
        return ""

    def _complaints(self, inputs: Inputs, now_ns: int) -> tuple[str, str]:
        """Of each estimator, also of one that says nothing any more."""
        silent = ["silent" if 2 * (now_ns - arrival) > self._timeout_ns else "" for arrival in inputs.springs_ns]
        return inputs.complaints[0] or silent[0], inputs.complaints[1] or silent[1]

    def _age_fault(self, name: str, arrival_ns: int, timeout_ns: int, inputs: Inputs, now_ns: int) -> str:
        """What will be older than `timeout_ns` before the next look, by its arrival or by its stamp."""
        limit_ns = max(timeout_ns - self._period_ns, timeout_ns // 2)
        if now_ns - arrival_ns > limit_ns:
            return f"{name} silent"
        age_ns = now_ns - inputs.measured_ns.get(name, arrival_ns)
        if age_ns > limit_ns:
            return f"{name} comes late: more than {limit_ns // 1_000_000} ms old by its stamps"
        return f"{name} is stamped in the future: do the clocks agree?" if age_ns < -AHEAD_NS else ""

    def _force_fault(self, number: int, force: float, spring: Spring, now_ns: int) -> str:
        config = self._config
        # a damper of a rod that comes back takes its share; no force at all is slack in any case
        if force < max(spring.force_offset - config.slack_margin - spring.damper_most, LEAST_FORCE):
            return f"transmission_{number} slack or its force sensor off: {force:.3g} N"
        if force > OVERLOAD * config.force_max:
            return f"transmission_{number} over its limit: {force:.3g} N"
        if config.frozen_timeout and now_ns - self._seen_ns[number - 1] > config.frozen_timeout * SECOND_NS:
            return f"force of transmission_{number} frozen at {force:.6g} N"
        return ""

    def _look_at_forces(self, inputs: Inputs, now_ns: int) -> None:
        """Real sensors have noise: a reading that never changes is none."""
        if inputs.joint is None:
            return
        for side, (tension, before) in enumerate(zip(inputs.joint.tension, self._tension, strict=True)):
            if tension != before:
                self._seen_ns[side] = now_ns
        self._tension = inputs.joint.tension

    def _live(self, inputs: Inputs) -> Live | None:
        joint, (first, second) = inputs.joint, inputs.springs
        if joint is None or inputs.motors is None or first is None or second is None:
            return None
        if joint.damping_valid:
            self._damping = joint.damping  # beyond the dampers' peak the last known one is nearer than none
        return Live(inputs.angle, joint.tension, joint.stiffness, self._damping, inputs.motors, (first, second))


def _because(fault: str, complaints: tuple[str, str]) -> str:
    """A fault with what the estimators complain of."""
    said = [f"transmission_{number}: {text}" for number, text in enumerate(complaints, 1) if text]
    return f"{fault} ({'; '.join(said)})" if said else fault
