"""Node: force and encoder of one transmission in, its impedance out."""

import time
from operator import itemgetter
from typing import Any, cast

from geometry_msgs.msg import WrenchStamped
from rclpy.clock import ROSClock
from rclpy.subscription import Subscription
from rclpy.timer import Timer
from sensor_msgs.msg import JointState
from std_msgs.msg import Header
from std_srvs.srv import Trigger
from vsa_common.ros.cdr import Writer, read_position, read_wrench
from vsa_common.ros.diagnostics import CounterDelta, format_increases
from vsa_common.ros.node import BEST_EFFORT, ERROR, OK, RELIABLE, STALE, WARN, Health, SuiteNode
from vsa_common.ros.process import run
from vsa_common.ros.throttle import ThrottledPublisher
from vsa_common.types import ResetReason, Status
from vsa_estimator.formulations import create_estimator
from vsa_estimator.offline.flight_recorder import FlightRecorder
from vsa_estimator.output.estimate import Estimate, State
from vsa_estimator.preprocessing.pairing import Pairing
from vsa_estimator.settings import NodeConfig
from vsa_msgs.msg import EstimatorState, TransmissionImpedance

WATCH = 0.005  # how often silence is looked for [s]
STARVED_NS = 20_000_000  # a watch that comes so late was starved; for as long it lets come first what has queued up
IMPATIENT_NS = 200_000_000  # silence after which it no longer does
STEP_NS = 10_000_000  # silence is predicted through in these steps: told late where it must be, but never left out
CLOCK_NS = 5_000_000  # a look at the ROS clock is dear
NO_SAMPLES = "no samples"  # what is said of STALE
FIRST_STEP = 5  # the shortest silence that is spoken of, in steps
STEPS = 10  # at most, at a time


def _fields(message: Any) -> list[str]:
    return [name for name in message.get_fields_and_field_types() if name != "header"]


_LEVEL = {Status.VALID: OK, Status.STALE: STALE, Status.FAULT: ERROR}
impedance_of = itemgetter(*(Estimate._fields.index(name) for name in _fields(TransmissionImpedance)))
_TEXTS = ("reason", "observability")
_NUMBERS = [name for name in _fields(EstimatorState) if name not in _TEXTS]
_MATRIX = _NUMBERS.index("coefficient_covariance")
_before_matrix = itemgetter(*(State._fields.index(name) for name in _NUMBERS[:_MATRIX]))
_after_matrix = itemgetter(*(State._fields.index(name) for name in _NUMBERS[_MATRIX + 1 :]))


class EstimatorNode(SuiteNode[NodeConfig]):
    """Estimate the impedance of one transmission from its force and deflection."""

    def __init__(self, name: str = "estimator", namespace: str = "vsa", **defaults: Any) -> None:
        super().__init__(name, NodeConfig, namespace, **defaults)
        self.stamp_ns = self.arrival_ns = 0  # of the last sample; arrival on the steady clock

    def start(self) -> None:
        config = self.config
        name = config.transmission
        self._estimator = create_estimator(config)
        recorder = config.flight_recorder
        self._recorder = FlightRecorder(recorder, name) if recorder.folder else None
        self._pairing = Pairing(int(config.pairing_tolerance * 1e9), int(config.reorder_window * 1e9))
        self._writer = Writer(TransmissionImpedance(header=Header(frame_id=name)))
        self._state_texts: tuple[str, tuple[str, ...]] = "", ()
        self._state_writer = self._writer_of_states()
        self._status = Status.INITIALIZING
        self._reset_count = 0
        self._future_ns = int(config.future_tolerance * 1e9)
        self._state_period_ns = int(1e9 / config.state_rate)
        self._refused = {f"{name}/force": 0, f"{name}/encoder": 0}
        self.stamp_ns = self.arrival_ns = 0
        self._published_ns = self._state_ns = self._watched_ns = self._patient_ns = 0
        self._overtaken = 0  # estimates that a prediction of a later instant was told before
        self._stamp_seen_ns = -1
        self._looked_ns = self._future_from_ns = 0
        self._recent = CounterDelta()
        self._ros_clock = cast("ROSClock", self.get_clock())
        self._impedances = ThrottledPublisher(self, TransmissionImpedance, f"{name}/impedance")
        self._states = self.create_publisher(EstimatorState, f"{name}/estimator_state", RELIABLE)
        self._inputs = self.listen()
        self._reset = self.create_service(Trigger, "~/reset", self._on_reset)
        self._watches = self.watch()

    def listen(self) -> list[Subscription]:
        """Subscribe to both sensors; whoever calls `take` overrides this."""
        name = self.config.transmission
        qos = RELIABLE if self.config.reliability == "reliable" else BEST_EFFORT
        return [
            self.create_subscription(WrenchStamped, f"{name}/force", self._on_force, qos, raw=True),
            self.create_subscription(JointState, f"{name}/encoder", self._on_encoder, qos, raw=True),
        ]

    def watch(self) -> list[Timer]:
        """Look for silence now and then; whoever calls `predict_to` overrides this."""
        return [self.create_timer(WATCH, self._on_watch, clock=self.steady)]

    def stop(self) -> None:
        for timer in self._watches:
            self.destroy_timer(timer)
        self.destroy_service(self._reset)
        for subscription in self._inputs:
            self.destroy_subscription(subscription)
        for publisher in (*self._impedances.publishers, self._states):
            self.destroy_publisher(publisher)
        if self._recorder is not None:
            self._recorder.close()

    def health(self) -> Health:
        if not self.active:
            return super().health()
        state = self._estimator.state()
        status = self._status
        values: dict[str, object] = {
            "status": status.name,
            "samples_fused": state.samples_fused,
            "samples_dropped": state.samples_dropped,
            "unpaired": self._pairing.dropped,
            "estimates_overtaken": self._overtaken,
            "force_rejected": state.force_rejected,
            "deflection_rejected": state.deflection_rejected,
            "force_repeated": state.force_repeated,
            "resets": state.reset_count,
            "last_reset": ResetReason(state.reset_reason).name,
        }
        refused = {f"refused_stamps {topic}": count for topic, count in self._refused.items()}
        values |= refused
        words = [state.reason] if state.reason else []
        if self._recorder is not None:
            values["flight_recordings"] = self._recorder.files
            words += [self._recorder.failed] if self._recorder.failed else []
        lost = {name: getattr(state, name) for name in ("samples_dropped", "force_rejected", "deflection_rejected")}
        lost |= {"unpaired": self._pairing.dropped, "resets": state.reset_count}
        trouble = self._recent.increases(lost | refused, time.monotonic())
        wrong = [topic for topic in self._refused if f"refused_stamps {topic}" in trouble]
        if wrong:
            return WARN, f"stamps of {' and '.join(wrong)} are zero or in the future", values
        if status is Status.STALE:
            return STALE, NO_SAMPLES, values
        words += [format_increases(trouble)] if trouble else []
        level = WARN if trouble and status is Status.VALID else _LEVEL.get(status, WARN)
        return level, "; ".join(words) or "active", values

    def _on_force(self, data: bytes) -> None:
        stamp_ns, force = read_wrench(data)
        if self.refuse(stamp_ns, "force"):
            return
        for sample in self._pairing.add_force(stamp_ns, force):
            self.take(*sample)

    def _on_encoder(self, data: bytes) -> None:
        stamp_ns, deflection = read_position(data)
        if self.refuse(stamp_ns, "encoder"):
            return
        for sample in self._pairing.add_encoder(stamp_ns, deflection):
            self.take(*sample)

    def refuse(self, stamp_ns: int, sensor: str) -> bool:
        """Whether a stamp is zero or in the future; it is counted then."""
        if stamp_ns == self._stamp_seen_ns or 0 < stamp_ns <= self._latest_ns(stamp_ns):
            self._stamp_seen_ns = stamp_ns
            return False
        self._refused[f"{self.config.transmission}/{sensor}"] += 1
        return True

    def _latest_ns(self, stamp_ns: int) -> int:
        """From which on a stamp is in the future, by a look at the clock that is as old as CLOCK_NS at most."""
        steady_ns = time.monotonic_ns()
        if steady_ns - self._looked_ns > CLOCK_NS or stamp_ns > self._future_from_ns:
            self._looked_ns = steady_ns
            self._future_from_ns = self._ros_clock.now().nanoseconds + self._future_ns
        return self._future_from_ns

    def take(self, stamp_ns: int, force: float, deflection: float) -> None:
        """Estimate from one sample of force [N] and deflection [m], and publish; nothing while inactive."""
        with self.lock:
            if not self.active:
                return
            estimate = self._estimator.add(stamp_ns, force, deflection)
            if self._recorder is not None:
                self._recorder.add(stamp_ns, force, deflection)
            if estimate is None:
                return
            self.stamp_ns = stamp_ns
            self.arrival_ns = time.monotonic_ns()
            if estimate.reset_count != self._reset_count and estimate.reset_reason is ResetReason.TIME_JUMP:
                self._published_ns = self._state_ns = 0
            self._publish(estimate)
            self.on_told()

    def on_estimate(self, estimate: Estimate) -> None:
        """Publish one estimate; whoever needs it sooner overrides this."""
        data = self._writer.write(estimate.stamp_ns, impedance_of(estimate))
        self._impedances.publish(estimate.stamp_ns, data, (estimate.status, estimate.stiffness_valid))

    def on_told(self) -> None:
        """Do what could wait until the estimate was out; whoever has no time now calls `finish_pending` later."""
        self.finish_pending()

    def finish_pending(self) -> bool:
        """Do something that the last sample has left to do; whether there was anything."""
        with self.lock:
            return self.active and self._estimator.finish_pending()

    def on_state_due(self, estimate: Estimate) -> None:
        """Tell what is known, `state_rate` times a second; whoever has no time now calls `tell_state` later."""
        self.tell_state(estimate)

    def _publish(self, estimate: Estimate) -> None:
        if estimate.stamp_ns <= self._published_ns:
            self._overtaken += 1
            return
        self._published_ns = estimate.stamp_ns
        if self._recorder is not None:
            self._recorder.watch(estimate)
        news = estimate.status is not self._status
        self._status, self._reset_count = estimate.status, estimate.reset_count
        self.on_estimate(estimate)
        if news or estimate.stamp_ns - self._state_ns >= self._state_period_ns:
            self._state_ns = estimate.stamp_ns
            self.on_state_due(estimate)

    def tell_state(self, estimate: Estimate) -> None:
        """Publish what the estimator knows; `estimate` is its last."""
        with self.lock:
            state = self._estimator.state()
        texts = NO_SAMPLES if estimate.status is Status.STALE else state.reason, state.observability
        if texts != self._state_texts:
            self._state_texts = texts
            self._state_writer = self._writer_of_states()
        dropped = state.samples_dropped + self._pairing.dropped + sum(self._refused.values())
        state = state._replace(status=estimate.status, samples_dropped=dropped)
        numbers = *_before_matrix(state), *state.coefficient_covariance, *_after_matrix(state)
        self._states.publish(self._state_writer.write(estimate.stamp_ns, numbers))

    def _writer_of_states(self) -> Writer:
        reason, lines = self._state_texts
        header = Header(frame_id=self.config.transmission)
        return Writer(EstimatorState(header=header, reason=reason, observability=list(lines)))

    def _on_watch(self) -> None:
        """After a starved moment, what has queued up comes first."""
        now_ns = time.monotonic_ns()
        if now_ns - self._watched_ns > STARVED_NS:
            self._patient_ns = now_ns + STARVED_NS
        self._watched_ns = now_ns
        silence_ns = now_ns - self.arrival_ns
        if now_ns >= self._patient_ns or silence_ns > IMPATIENT_NS:
            self.predict_to(silence_ns)

    def predict_to(self, silence_ns: int) -> None:
        """Predict on: the sensors have been silent for so long."""
        if not self.arrival_ns or silence_ns < FIRST_STEP * STEP_NS:
            return
        with self.lock:
            if not self.active:
                return
            first = max(FIRST_STEP, (self._published_ns - self.stamp_ns) // STEP_NS + 1)
            last = min(self._silence(silence_ns) // STEP_NS, first + STEPS - 1)
            for step in range(first, last + 1):
                estimate = self._estimator.predict_to(self.stamp_ns + step * STEP_NS)
                if estimate is not None:
                    self._publish(estimate)

    def _silence(self, silence_ns: int) -> int:
        """Of the sensors' clock: a simulated one that stands still lets nothing grow old."""
        if not self._ros_clock.ros_time_is_active:
            return silence_ns
        return min(silence_ns, self._ros_clock.now().nanoseconds - self.stamp_ns)

    def _on_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        with self.lock:
            self._estimator.reset(ResetReason.REQUESTED)
        response.success = True
        return response


def main() -> int:
    """Entry point."""
    return run(EstimatorNode)
