# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Base class of the suite's nodes: a lifecycle node with checked parameters, autostart, log and diagnostics.

A node file checks its configuration in `configure`, creates its topics in `start`, releases its core in `stop`, and
ends with `main = lambda: run(ItsNode)`, of `vsa_common.ros.process`.
"""

import threading
import time
from collections.abc import Callable
from copy import copy
from typing import Any, Generic, NoReturn, TypeVar

from rclpy.clock import Clock, ClockType
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from vsa_common.config.configuration import ConfigurationError
from vsa_common.ros.diagnostics import CHECK_PERIOD, ERROR, OK, WARN, DiagnosticsPublisher, Health, Tasks
from vsa_common.ros.log import HealthLog, await_log_reader
from vsa_common.ros.parameters import Common, NodeParameters
from vsa_common.ros.qos import QosMonitor

__all__ = ["BEST_EFFORT", "ERROR", "OK", "RELIABLE", "STEADY", "WARN", "Health", "RCLError", "SuiteNode", "Tasks"]

Config = TypeVar("Config")

STEADY = Clock(clock_type=ClockType.STEADY_TIME)
RELIABLE = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
BEST_EFFORT = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)

RCLError = rclpy_implementation.RCLError


class StartRefused(ConfigurationError):
    """A node cannot start; the reason is in its log already."""


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
        self._state = "unconfigured"  # the lifecycle state
        self._failure = ""  # why the last transition failed
        try:
            self._declared = NodeParameters(self, config_class, defaults, lambda: self._active, self._apply)
        except ConfigurationError as error:
            self.refuse_start(str(error))
        self._reject_illegal_transitions()
        self._qos_monitor = QosMonitor(self)
        self._diagnostics = DiagnosticsPublisher(self)
        self._health_log = HealthLog(self.get_logger())
        self.create_timer(CHECK_PERIOD, self.publish_health, clock=self.steady)

    # Overridden by the nodes of the suite.

    def configure(self) -> None:
        """Open and check what `start` needs, and release it. Raise ConfigurationError or OSError where it fails."""

    def start(self) -> None:
        """Create topics, timers and core. Raise ConfigurationError where that is impossible."""

    def stop(self) -> None:
        """Undo `start`. Called once for each successful `start`, also when the process ends."""

    def reconfigure(self, config: Config) -> None:
        """Apply changed tunable parameters while active, before `config` has them.

        Raise ConfigurationError to reject the change.
        """

    def health(self) -> Tasks:
        """While active: level (OK, WARN, ERROR), one line, and key values of each of `tasks`."""
        return dict.fromkeys(self.tasks, (OK, "active", {}))

    @property
    def tasks(self) -> tuple[str, ...]:
        """Names of the node's tasks in the diagnostics; a failed transition is reported by the first."""
        return ("node",)

    @property
    def hardware_id(self) -> str:
        """What the node's diagnostics are about."""
        return self.get_namespace().strip("/")

    @property
    def activity(self) -> str:
        """What the active node does, for the log: bus, transmissions, rate."""
        return ""

    # Topics, without rclpy's QoS events: see vsa_common.ros.qos. Parameters `qos_overrides.*` change the policies, of a
    # copy: rclpy writes them into the profile that it is given, and one profile serves many topics.

    def create_publisher(self, msg_type: Any, topic: str, qos_profile: Any, **options: Any) -> Any:
        options |= _options(topic, PublisherEventCallbacks(use_default_callbacks=False))
        return super().create_publisher(msg_type, topic, copy(qos_profile), **options)

    def create_subscription(self, msg_type: Any, topic: str, callback: Any, qos_profile: Any, **options: Any) -> Any:
        options |= _options(topic, SubscriptionEventCallbacks(use_default_callbacks=False))
        return super().create_subscription(msg_type, topic, callback, copy(qos_profile), **options)

    # Lifecycle.

    @property
    def active(self) -> bool:
        """Whether the node is in the lifecycle state active."""
        return self._active

    def autostart(self) -> None:
        """Configure and activate, if the parameter is true; StartRefused where the node cannot start."""
        if not self.common.autostart:
            return
        self.trigger_configure()
        if not self._failure:
            self.trigger_activate()
        if not self._active:
            await_log_reader(self)
            raise StartRefused(self._failure)

    def refuse_start(self, reason: str) -> NoReturn:
        """Log the reason, until a reader of /rosout has it, and end the node. Raises StartRefused."""
        self.get_logger().fatal(reason)
        await_log_reader(self)
        self.destroy_node()
        raise StartRefused(reason)

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        if not self._attempt(self.configure):
            return TransitionCallbackReturn.FAILURE
        self._enter("inactive", "configured")
        return super().on_configure(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        if not self._attempt(self._activate):
            return TransitionCallbackReturn.FAILURE
        self._enter("active", f"active: {self.activity}".rstrip(": "))
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.close()
        self._enter("inactive", "inactive")
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        self._enter("unconfigured", "unconfigured")
        return super().on_cleanup(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.close()
        self._enter("finalized", "finalized")
        return super().on_shutdown(state)

    def close(self) -> None:
        """Stop if active."""
        with self.lock:
            if self._active:
                self._active = False
                self.stop()

    def _activate(self) -> None:
        with self.lock:
            self.start()
            self._active = True

    def _attempt(self, step: Callable[[], None]) -> bool:
        """Whether a step of a transition succeeds; the reason of a failure is logged and in the diagnostics."""
        try:
            step()
        except Exception as error:  # of rclpy, for instance a RuntimeError: with its type
            self._failure = " ".join((str if isinstance(error, ConfigurationError | OSError) else repr)(error).split())
            self.get_logger().error(self._failure)
            return False
        return True

    def _enter(self, state: str, line: str) -> None:
        self._state, self._failure = state, ""
        self._health_log.restart()
        self.get_logger().info(line)

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

    def publish_health(self) -> None:
        """Publish and log a changed health; a timer calls it every CHECK_PERIOD."""
        if self._qos_monitor.check_next():
            self.get_logger().warning(self._qos_monitor.message)
        now = time.monotonic()
        with self.lock:
            tasks = self._health()
        self._health_log.update(tasks, now)
        self._diagnostics.publish(self.hardware_id, {**tasks, "topics": self._qos_monitor.health()}, now)

    def _health(self) -> Tasks:
        if self._active:
            return self.health()
        tasks: dict[str, Health] = dict.fromkeys(self.tasks, (OK, self._state, {}))
        if self._failure:
            tasks[self.tasks[0]] = ERROR, self._failure, {}
        return tasks


def _options(topic: str, events: Any) -> dict[str, Any]:
    """Options of a topic: no QoS events; policies by parameters unless rclpy creates it before there are any."""
    overridable = topic not in ("/parameter_events", "/rosout")
    policies = QoSOverridingOptions.with_default_policies() if overridable else None
    return {"event_callbacks": events, "qos_overriding_options": policies}
