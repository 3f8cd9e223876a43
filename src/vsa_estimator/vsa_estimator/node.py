"""Node of one transmission. Input: force and encoder topics. Output: impedance and estimator_state topics."""

import time
from typing import Any, cast

from geometry_msgs.msg import WrenchStamped
from rclpy.clock import ROSClock
from rclpy.subscription import Subscription
from rclpy.timer import Timer
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from vsa_common.ros.cdr import read_position, read_wrench
from vsa_common.ros.diagnostics import CounterDelta, format_increases
from vsa_common.ros.node import BEST_EFFORT, ERROR, OK, RELIABLE, STALE, WARN, Health, SuiteNode
from vsa_common.ros.process import run
from vsa_common.ros.throttle import ThrottledPublisher
from vsa_common.types import ResetReason, Status
from vsa_estimator.formulations import create_estimator
from vsa_estimator.offline.flight_recorder import FlightRecorder
from vsa_estimator.output.estimate import Estimate
from vsa_estimator.output.messages import ImpedanceWriter, StateWriter
from vsa_estimator.preprocessing.pairing import Pairing
from vsa_estimator.settings import NodeConfig
from vsa_msgs.msg import EstimatorState, TransmissionImpedance

WATCHDOG_PERIOD = 0.005  # of the check for silence [s]
STARVED_NS = 20_000_000  # a check later than this was starved: queued samples come first for as long [ns]
MAX_DEFERRAL_NS = 200_000_000  # silence after which predictions are not deferred [ns]
PREDICTION_STEP_NS = 10_000_000  # interval of predicted estimates in silence [ns]
FIRST_STEP = 5  # first predicted estimate after a silence of so many steps: 50 ms, the limit of STALE
MAX_STEPS = 10  # predicted estimates in one call
CLOCK_CACHE_NS = 5_000_000  # age of a reading of the ROS clock that is used again: a reading costs 10 us [ns]
NO_SAMPLES = "no samples"  # reason of STALE

_COUNTERS = ("samples_fused", "samples_dropped", "force_rejected", "deflection_rejected", "force_repeated")
_LEVEL = {Status.VALID: OK, Status.STALE: STALE, Status.FAULT: ERROR}


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
        self._writer = ImpedanceWriter(name)
        self._state_writer = StateWriter(name)
        self._status = Status.INITIALIZING
        self._reset_count = 0
        self._future_ns = int(config.future_tolerance * 1e9)
        self._state_period_ns = int(1e9 / config.state_rate)
        self._refused = {f"{name}/force": 0, f"{name}/encoder": 0}
        self.stamp_ns = self.arrival_ns = 0
        self._published_ns = self._state_ns = self._checked_ns = self._deferred_until_ns = 0
        self._overtaken = 0  # estimates with stamps before that of a published prediction
        self._checked_stamp_ns = -1
        self._clock_read_ns = self._future_from_ns = 0
        self._increases = CounterDelta()
        self._ros_clock = cast("ROSClock", self.get_clock())
        self._impedances = ThrottledPublisher(self, TransmissionImpedance, f"{name}/impedance")
        self._states = self.create_publisher(EstimatorState, f"{name}/estimator_state", RELIABLE)
        self._inputs = self.create_inputs()
        self._reset = self.create_service(Trigger, "~/reset", self._on_reset)
        self._watchdogs = self.create_watchdogs()

    def create_inputs(self) -> list[Subscription]:
        """Subscribe to both sensors; overridden where `process` is called directly."""
        name = self.config.transmission
        qos = RELIABLE if self.config.reliability == "reliable" else BEST_EFFORT
        return [
            self.create_subscription(WrenchStamped, f"{name}/force", self._on_force, qos, raw=True),
            self.create_subscription(JointState, f"{name}/encoder", self._on_encoder, qos, raw=True),
        ]

    def create_watchdogs(self) -> list[Timer]:
        """Timers that check for silence; overridden where `predict_silence` is called directly."""
        return [self.create_timer(WATCHDOG_PERIOD, self._on_watchdog, clock=self.steady)]

    def stop(self) -> None:
        for timer in self._watchdogs:
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
        values: dict[str, object] = {"status": status.name} | {name: getattr(state, name) for name in _COUNTERS}
        values |= {"unpaired": self._pairing.dropped, "estimates_overtaken": self._overtaken}
        values |= {"resets": state.reset_count, "last_reset": ResetReason(state.reset_reason).name}
        refused = {f"refused_stamps {topic}": count for topic, count in self._refused.items()}
        values |= refused
        texts = [state.reason] if state.reason else []
        if self._recorder is not None:
            values["flight_recordings"] = self._recorder.files
            texts += [self._recorder.failed] if self._recorder.failed else []
        lost = {name: getattr(state, name) for name in _COUNTERS[1:4]}
        lost |= {"unpaired": self._pairing.dropped, "resets": state.reset_count}
        increases = self._increases.increases(lost | refused, time.monotonic())
        wrong = [topic for topic in self._refused if f"refused_stamps {topic}" in increases]
        if wrong:
            return WARN, f"stamps of {' and '.join(wrong)} are zero or in the future", values
        if status is Status.STALE:
            return STALE, NO_SAMPLES, values
        texts += [format_increases(increases)] if increases else []
        level = WARN if increases and status is Status.VALID else _LEVEL.get(status, WARN)
        return level, "; ".join(texts) or "active", values

    def _on_force(self, data: bytes) -> None:
        stamp_ns, force = read_wrench(data)
        if self.refuse(stamp_ns, "force"):
            return
        for sample in self._pairing.add_force(stamp_ns, force):
            self.process(*sample)

    def _on_encoder(self, data: bytes) -> None:
        stamp_ns, deflection = read_position(data)
        if self.refuse(stamp_ns, "encoder"):
            return
        for sample in self._pairing.add_encoder(stamp_ns, deflection):
            self.process(*sample)

    def refuse(self, stamp_ns: int, sensor: str) -> bool:
        """Count a stamp that is zero or in the future; whether it is one."""
        if stamp_ns == self._checked_stamp_ns or 0 < stamp_ns <= self._latest_ns(stamp_ns):
            self._checked_stamp_ns = stamp_ns
            return False
        self._refused[f"{self.config.transmission}/{sensor}"] += 1
        return True

    def _latest_ns(self, stamp_ns: int) -> int:
        """Latest acceptable stamp [ns], by a reading of the ROS clock that is at most CLOCK_CACHE_NS old."""
        steady_ns = time.monotonic_ns()
        if steady_ns - self._clock_read_ns > CLOCK_CACHE_NS or stamp_ns > self._future_from_ns:
            self._clock_read_ns = steady_ns
            self._future_from_ns = self._ros_clock.now().nanoseconds + self._future_ns
        return self._future_from_ns

    def process(self, stamp_ns: int, force: float, deflection: float) -> None:
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
            self.on_published()

    def on_estimate(self, estimate: Estimate) -> None:
        """Publish one estimate; overridden where it is passed on directly."""
        data = self._writer.write(estimate)
        self._impedances.publish(estimate.stamp_ns, data, (estimate.status, estimate.stiffness_valid))

    def on_published(self) -> None:
        """Do the deferred work of the last sample; overridden where `finish_pending` is called later."""
        self.finish_pending()

    def finish_pending(self) -> bool:
        """Do one part of the deferred work; whether there was any."""
        with self.lock:
            return self.active and self._estimator.finish_pending()

    def on_state_due(self, estimate: Estimate) -> None:
        """Publish the state at `state_rate`; overridden where `publish_state` is called later."""
        self.publish_state(estimate)

    def _publish(self, estimate: Estimate) -> None:
        if estimate.stamp_ns <= self._published_ns:
            self._overtaken += 1
            return
        self._published_ns = estimate.stamp_ns
        if self._recorder is not None:
            self._recorder.watch(estimate)
        changed = estimate.status is not self._status
        self._status, self._reset_count = estimate.status, estimate.reset_count
        self.on_estimate(estimate)
        if changed or estimate.stamp_ns - self._state_ns >= self._state_period_ns:
            self._state_ns = estimate.stamp_ns
            self.on_state_due(estimate)

    def publish_state(self, estimate: Estimate) -> None:
        """Publish the present state at the stamp of the last `estimate`."""
        with self.lock:
            state = self._estimator.state()
        reason = NO_SAMPLES if estimate.status is Status.STALE else state.reason
        dropped = state.samples_dropped + self._pairing.dropped + sum(self._refused.values())
        state = state._replace(status=estimate.status, samples_dropped=dropped, reason=reason)
        self._states.publish(self._state_writer.write(estimate.stamp_ns, state))

    def _on_watchdog(self) -> None:
        """Predict in silence; after a starved moment queued samples come first."""
        now_ns = time.monotonic_ns()
        if now_ns - self._checked_ns > STARVED_NS:
            self._deferred_until_ns = now_ns + STARVED_NS
        self._checked_ns = now_ns
        silence_ns = now_ns - self.arrival_ns
        if now_ns >= self._deferred_until_ns or silence_ns > MAX_DEFERRAL_NS:
            self.predict_silence(silence_ns)

    def predict_silence(self, silence_ns: int) -> None:
        """Publish predictions for sensors that have been silent for `silence_ns` [ns]."""
        if not self.arrival_ns or silence_ns < FIRST_STEP * PREDICTION_STEP_NS:
            return
        with self.lock:
            if not self.active:
                return
            first = max(FIRST_STEP, (self._published_ns - self.stamp_ns) // PREDICTION_STEP_NS + 1)
            last = min(self._silence_on_ros_clock(silence_ns) // PREDICTION_STEP_NS, first + MAX_STEPS - 1)
            for step in range(first, last + 1):
                estimate = self._estimator.predict_to(self.stamp_ns + step * PREDICTION_STEP_NS)
                if estimate is not None:
                    self._publish(estimate)

    def _silence_on_ros_clock(self, silence_ns: int) -> int:
        """Silence on the clock of the sensors [ns]: a simulated one may stand still."""
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
