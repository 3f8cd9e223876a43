"""Base class of the suite's nodes: a lifecycle node with checked parameters, autostart and diagnostics.

A node file creates its topics in `start`, releases its core in `stop`, and ends with `main = lambda: run(ItsNode)`, of
`vsa_common.ros.process`.
"""

import threading
from collections.abc import Mapping, Sequence
from typing import Any, Generic, TypeVar, cast

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter as RosParameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from vsa_common.config.configuration import ConfigurationError, build, flatten, parameters
from vsa_common.ros.diagnostics import CHECK_PERIOD, ERROR, OK, STALE, WARN, DiagnosticsPublisher
from vsa_common.ros.parameters import COMMON, Common, descriptor, is_ours, ros_value
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
        self._config_class = config_class
        self._defaults = defaults
        self.lock = threading.RLock()
        self._active = False
        self._starting = False
        self.failure = ""
        try:
            self.config = self._declare()
        except ConfigurationError as error:
            raise ConfigurationError(f"{self.get_name()}: {error}") from error
        self.add_on_set_parameters_callback(self._on_parameters)
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
        """Apply a checked configuration; raise ConfigurationError to reject it and keep the present one."""
        if self._active:
            raise ConfigurationError("cannot change while the node is active; deactivate it first")

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

    def _declare(self) -> Config:
        overrides = cast("Mapping[str, RosParameter]", self.get_parameters_by_prefix(""))
        given = {name: override.value for name, override in overrides.items() if is_ours(name)}
        self.common = build(Common, {name: value for name, value in given.items() if name in COMMON})
        own = {name: value for name, value in given.items() if name not in COMMON}
        config = build(self._config_class, {**self._defaults, **own})
        for one in (config, self.common):
            values = flatten(one)
            for parameter in parameters(type(one)):
                self._describe(parameter.name, ros_value(values[parameter.name]), descriptor(parameter))
        return config

    def _describe(self, name: str, value: Any, descriptor: ParameterDescriptor) -> None:
        if self.has_parameter(name):
            self.undeclare_parameter(name)
        self.declare_parameter(name, value, descriptor, ignore_override=True)

    def _on_parameters(self, changes: Sequence[RosParameter]) -> SetParametersResult:
        ours = {change.name: change.value for change in changes if is_ours(change.name)}
        at_start = {name: ours.pop(name) for name in COMMON.intersection(ours)}
        try:
            self.common = build(Common, {**flatten(self.common), **at_start})
            if not ours:
                return SetParametersResult(successful=True)
            config = build(self._config_class, {**flatten(self.config), **ours})
            with self.lock:
                self.reconfigure(config)
        except ConfigurationError as error:
            return SetParametersResult(successful=False, reason=str(error))
        self.config = config
        return SetParametersResult(successful=True)

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
