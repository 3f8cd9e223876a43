"""Base class of the suite's nodes: a lifecycle node with checked parameters, autostart and diagnostics.

A node file creates its topics in `start`, releases its core in `stop`, and ends with `main = lambda: run(ItsNode)`, of
`vsa_common.ros.process`.
"""

import threading
from collections.abc import Mapping
from typing import Any, Generic, TypeVar

from rclpy.clock import Clock, ClockType
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.qos import QoSProfile, ReliabilityPolicy
from vsa_common.config.configuration import ConfigurationError
from vsa_common.ros.diagnostics import CHECK_PERIOD, ERROR, OK, STALE, WARN, DiagnosticsPublisher
from vsa_common.ros.parameters import Common, NodeParameters
from vsa_common.ros.qos import QosMonitor

__all__ = ["BEST_EFFORT", "ERROR", "OK", "RELIABLE", "STALE", "STEADY", "WARN", "Health", "RCLError", "SuiteNode"]

Config = TypeVar("Config")
Health = tuple[int, str, Mapping[str, object]]

STEADY = Clock(clock_type=ClockType.STEADY_TIME)
RELIABLE = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
BEST_EFFORT = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)

RCLError = rclpy_implementation.RCLError


class SuiteNode(LifecycleNode, Generic[Config]):
    """A lifecycle node that configures and activates itself unless `autostart` is false.

    `lock` guards the state that `start`, `stop` and `health` share with threads other than the executor's.
    """

    def __init__(self, name: str, config_class: type[Config], namespace: str = "vsa", **defaults: Any) -> None:
        """`defaults` replace the defaults of `config_class`. Raises ConfigurationError for a bad parameter."""
        try:
            super().__init__(name, namespace=namespace, automatically_declare_parameters_from_overrides=True)
        except ValueError as error:  # rcl gives an empty list no type
            raise ConfigurationError(
                f"{name}: a parameter has no value; write an empty list as ['']: {error}"
            ) from error
        self.steady = Clock(clock_type=ClockType.STEADY_TIME)  # one clock for all nodes of a process gets slow
        self.lock = threading.RLock()
        self._active = False
        self._starting = False
        self.failure = ""
        try:
            self._declared = NodeParameters(self, config_class, defaults, lambda: self._active, self._apply)
        except ConfigurationError as error:
            raise ConfigurationError(f"{self.get_name()}: {error}") from error
        self._reject_illegal_transitions()
        self._qos_monitor = QosMonitor(self)
        self._diagnostics = DiagnosticsPublisher(self)
        self.create_timer(CHECK_PERIOD, self._publish_health, clock=self.steady)

    # Overridden by the nodes of the suite.

    def start(self) -> None:
        """Create topics, timers and core. Raise ConfigurationError where that is impossible."""

    def stop(self) -> None:
        """Undo `start`. Called once for each successful `start`, also when the process ends."""

    def reconfigure(self, config: Config) -> None:
        """Apply changed tunable parameters while active, before `config` has them.

        Raise ConfigurationError to reject the change.
        """

    def health(self) -> Health:
        """Level (OK, WARN, ERROR, STALE), one line, and key values for /diagnostics."""
        return OK, "active" if self._active else "inactive", {}

    # Topics, without rclpy's QoS events: see vsa_common.ros.qos.

    def create_publisher(self, msg_type: Any, topic: str, qos_profile: Any, **options: Any) -> Any:
        events = PublisherEventCallbacks(use_default_callbacks=False)
        return super().create_publisher(msg_type, topic, qos_profile, event_callbacks=events, **options)

    def create_subscription(self, msg_type: Any, topic: str, callback: Any, qos_profile: Any, **options: Any) -> Any:
        events = SubscriptionEventCallbacks(use_default_callbacks=False)
        return super().create_subscription(msg_type, topic, callback, qos_profile, event_callbacks=events, **options)

    # Lifecycle.

    @property
    def active(self) -> bool:
        """Whether the node is in the lifecycle state active."""
        return self._active

    def autostart(self) -> None:
        """Configure and activate, if the parameter is true; ConfigurationError where the node cannot start."""
        if not self.common.autostart:
            return
        self._starting = True
        self.trigger_configure()
        self.trigger_activate()
        self._starting = False
        if not self._active:
            raise ConfigurationError(self.failure or "cannot start")

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        try:
            with self.lock:
                self.start()
                self._active = True
        except (ConfigurationError, OSError) as error:
            self.failure = " ".join(str(error).split())
            if not self._starting:  # else `autostart` raises it
                self.get_logger().error(self.failure)
            return TransitionCallbackReturn.FAILURE
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.close()
        return super().on_deactivate(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.close()
        return super().on_shutdown(state)

    def close(self) -> None:
        """Stop if active."""
        with self.lock:
            if self._active:
                self._active = False
                self.stop()

    def _reject_illegal_transitions(self) -> None:
        """Answer a transition that the present state does not permit with a failure; in rclpy it ends the process."""
        change_state = self._service_change_state.callback

        def guarded(request: Any, response: Any) -> Any:
            try:
                return change_state(request, response)
            except RCLError as error:
                self.get_logger().warning(" ".join(str(error).split()))
                response.success = False
                return response

        self._service_change_state.callback = guarded

    # Parameters.

    @property
    def config(self) -> Config:
        """The present configuration."""
        return self._declared.config

    @property
    def common(self) -> Common:
        """Parameters that every node has."""
        return self._declared.common

    def _apply(self, config: Config) -> None:
        with self.lock:
            if self._active:
                self.reconfigure(config)

    # Diagnostics.

    def _publish_health(self) -> None:
        if self._qos_monitor.check_next():
            self.get_logger().warning(self._qos_monitor.message)
        with self.lock:
            level, message, values = self.health()
        if self._qos_monitor.conflicts:
            message = self._qos_monitor.message if level == OK else f"{message}; {self._qos_monitor.message}"
            level = max(level, WARN)
        self._diagnostics.publish(level, message, values)
