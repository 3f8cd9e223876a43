# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Node of one transmission. Input: topics of its sensors. Output: impedance and estimator_state topics."""

import time
from collections.abc import Sequence
from typing import Any, cast

from rclpy.clock import ROSClock
from rclpy.subscription import Subscription
from rclpy.timer import Timer
from vsa_common.ros.node import RELIABLE, WARN, SuiteNode, Tasks
from vsa_common.ros.process import run
from vsa_common.ros.throttle import ThrottledPublisher
from vsa_common.types import ResetReason, Status
from vsa_estimator.formulations import create_estimator
from vsa_estimator.offline.flight_recorder import FlightRecorder
from vsa_estimator.output.estimate import Estimate, State
from vsa_estimator.output.messages import ImpedanceWriter, StateWriter
from vsa_estimator.preprocessing.sequence_gaps import SequenceGaps
from vsa_estimator.ros.health import ESTIMATION, NO_SAMPLES, EstimatorHealth
from vsa_estimator.ros.sample_topics import SampleTopics
from vsa_estimator.ros.services import EstimatorServices
from vsa_estimator.ros.silence import FIRST_STEP, PREDICTION_STEP_NS, WATCHDOG_PERIOD, Watchdog, prediction_stamps
from vsa_estimator.ros.stamps import StampCheck
from vsa_estimator.settings import NodeConfig
from vsa_msgs.msg import EstimatorState, TransmissionImpedance

LOG_PERIOD_S = 1.0  # [s] at least between two lines on resets


class EstimatorNode(SuiteNode[NodeConfig]):
    """Estimate the impedance of one transmission from its force and deflection."""

    def __init__(self, name: str = "estimator", namespace: str = "vsa", **defaults: Any) -> None:
        super().__init__(name, NodeConfig, namespace, **defaults)
        self.stamp_ns = self.arrival_ns = 0  # of the last sample; arrival on the steady clock

    def configure(self) -> None:
        """Compile the estimator, and create the folder of the flight recorder."""
        create_estimator(self.config)
        _recorder(self.config)

    def start(self) -> None:
        config = self.config
        name = config.transmission
        self._estimator = create_estimator(config)
        self._recorder = _recorder(config)
        self._topics = SampleTopics(config, self.refuse, self.process, self.count)
        self._gaps = SequenceGaps()
        self._writer = ImpedanceWriter(config.frame_prefix + name)
        self._state_writer = StateWriter(config.frame_prefix + name)
        self._status = Status.INITIALIZING
        self._reset_count = 0
        self._state_period_ns = int(1e9 / config.state_rate)
        self.stamp_ns = self.arrival_ns = 0
        self._published_ns = self._state_ns = 0
        self._watchdog = Watchdog()
        self._overtaken = 0  # estimates with stamps before that of a published prediction
        self._health_monitor = EstimatorHealth()
        self._ros_clock = cast("ROSClock", self.get_clock())
        self._stamp_check = StampCheck(self._ros_clock, name, _ns(config.future_tolerance))
        self._impedances = ThrottledPublisher(self, TransmissionImpedance, f"{name}/impedance")
        self._states = self.create_publisher(EstimatorState, f"{name}/estimator_state", RELIABLE)
        self._inputs = self.create_inputs()
        self._estimator_services = EstimatorServices(self, self.state, self.reset)
        self._watchdogs = self.create_watchdogs()

    def create_inputs(self) -> list[Subscription]:
        """Subscribe to both sensors and their sequence numbers; overridden where `process` is called directly."""
        return self._topics.subscribe(self)

    def create_watchdogs(self) -> list[Timer]:
        """Timers that check for silence; overridden where `predict_silence` is called directly."""
        return [self.create_timer(WATCHDOG_PERIOD, self._on_watchdog, clock=self.steady)]

    def reconfigure(self, config: NodeConfig) -> None:
        if config.flight_recorder != self.config.flight_recorder:
            recorder, self._recorder = self._recorder, _recorder(config, self._reset_count)
            if recorder is not None:
                recorder.close()
        self._estimator.reconfigure(config)
        self._topics.reconfigure(config)
        self._stamp_check.set_tolerance(_ns(config.future_tolerance))
        self._state_period_ns = int(1e9 / config.state_rate)

    def stop(self) -> None:
        for timer in self._watchdogs:
            self.destroy_timer(timer)
        self._estimator_services.close()
        for subscription in self._inputs:
            self.destroy_subscription(subscription)
        for publisher in (*self._impedances.publishers, self._states):
            self.destroy_publisher(publisher)
        if self._recorder is not None:
            self._recorder.close()

    def health(self) -> Tasks:
        counts = {"unpaired": self._topics.dropped, "estimates_overtaken": self._overtaken}
        if self._recorder is not None:
            counts["flight_recordings"] = self._recorder.files
        state = self._estimator.state()
        level, text, values = self._health_monitor.assess(state, self._status, self._stamp_check.counts, counts)
        if self._recorder is not None and self._recorder.failed:
            level, text = max(level, WARN), f"{text}; {self._recorder.failed}"
        return {ESTIMATION: (level, text, values)}

    @property
    def tasks(self) -> tuple[str, ...]:
        return (ESTIMATION,)

    @property
    def hardware_id(self) -> str:
        return self.config.transmission

    @property
    def activity(self) -> str:
        config = self.config
        return f"{config.transmission}, formulation {config.formulation}, filter at {config.filter_rate:g} Hz"

    def count(self, stamps_ns: Sequence[int], sequence: Sequence[int]) -> None:
        """Take the sequence numbers of samples with these stamps [ns]; nothing while inactive."""
        with self.lock:
            if self.active:
                self._gaps.add(stamps_ns, sequence)
                self._estimator.count_lost(0)

    def refuse(self, stamp_ns: int, sensor: str) -> bool:
        """Count a stamp that is zero or in the future; whether it is one."""
        return self._stamp_check.refuse(stamp_ns, sensor)

    def process(self, stamp_ns: int, force: float, deflection: float) -> None:
        """Estimate from one sample of force [N] and deflection [m], and publish; nothing while inactive."""
        with self.lock:
            if not self.active:
                return
            if lost := self._gaps.lost_before(stamp_ns):
                self._estimator.count_lost(lost)
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
        if estimate.reset_count != self._reset_count:
            reason = ResetReason(estimate.reset_reason).name
            line = f"reset: {reason}, {estimate.reset_count} so far"
            self.get_logger().info(line, throttle_duration_sec=LOG_PERIOD_S)
        changed = estimate.status is not self._status
        self._status, self._reset_count = estimate.status, estimate.reset_count
        self.on_estimate(estimate)
        if changed or estimate.stamp_ns - self._state_ns >= self._state_period_ns:
            self._state_ns = estimate.stamp_ns
            self.on_state_due(estimate)

    def publish_state(self, estimate: Estimate) -> None:
        """Publish the present state at the stamp of the last `estimate`."""
        state = self.state()
        reason = NO_SAMPLES if estimate.status is Status.STALE else state.reason
        dropped = state.samples_dropped + self._topics.dropped + sum(self._stamp_check.counts.values())
        state = state._replace(status=estimate.status, samples_dropped=dropped, reason=reason)
        if not estimate.velocity_valid:
            state = state._replace(deflection_valid=False, velocity_valid=False, acceleration_valid=False)
        self._states.publish(self._state_writer.write(estimate.stamp_ns, state))

    def _on_watchdog(self) -> None:
        now_ns = time.monotonic_ns()
        silence_ns = now_ns - self.arrival_ns
        if self._watchdog.may_predict(now_ns, silence_ns):
            self.predict_silence(silence_ns)

    def predict_silence(self, silence_ns: int) -> None:
        """Publish predictions for sensors that have been silent for `silence_ns` [ns]."""
        if not self.arrival_ns or silence_ns < FIRST_STEP * PREDICTION_STEP_NS:
            return
        with self.lock:
            if not self.active:
                return
            silence_ns = self._silence_on_ros_clock(silence_ns)
            for stamp_ns in prediction_stamps(self.stamp_ns, self._published_ns, silence_ns):
                estimate = self._estimator.predict_to(stamp_ns)
                if estimate is not None:
                    self._publish(estimate)

    def _silence_on_ros_clock(self, silence_ns: int) -> int:
        """Silence on the clock of the sensors [ns]: a simulated one may stand still."""
        if not self._ros_clock.ros_time_is_active:
            return silence_ns
        return min(silence_ns, self._ros_clock.now().nanoseconds - self.stamp_ns)

    def state(self) -> State:
        """The state of the estimator."""
        with self.lock:
            return self._estimator.state()

    def reset(self) -> None:
        """Discard the estimate and start again from the initial coefficients."""
        with self.lock:
            self._estimator.reset(ResetReason.REQUESTED)


def _ns(seconds: float) -> int:
    return int(seconds * 1e9)


def _recorder(config: NodeConfig, reset_count: int = 0) -> FlightRecorder | None:
    recorder = config.flight_recorder
    return FlightRecorder(recorder, config.transmission, reset_count) if recorder.folder else None


def main() -> int:
    """Entry point."""
    return run(EstimatorNode)
