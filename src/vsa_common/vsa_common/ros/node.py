"""What every node of the suite is: a lifecycle node with checked parameters, autostart and diagnostics.

A node file adds its topics in `start`, drops its core in `stop`, and ends with `main = lambda: run(ItsNode)`, of
`vsa_common.ros.process`.
"""

import re
import threading
import time
from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any, Generic, TypeVar, cast

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter as RosParameter
from rclpy.publisher import Publisher
from rclpy.qos import QoSCompatibility, QoSProfile, ReliabilityPolicy, qos_check_compatible
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo
from vsa_common.config.configuration import ConfigurationError, build, flatten, parameters
from vsa_common.config.declared import COMMON, Common, descriptor, is_ours, ros_value

Config = TypeVar("Config")
Health = tuple[int, str, Mapping[str, object]]

OK, WARN, ERROR, STALE = 0, 1, 2, 3
REPORT = 1.0  # between two diagnostics at most [s]
LOOK = 0.2  # how soon other words, or another level, are told [s]
_POLICIES = "reliability", "durability", "deadline", "liveliness", "liveliness_lease_duration"
STEADY = Clock(clock_type=ClockType.STEADY_TIME)
RELIABLE = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
BEST_EFFORT = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)

RCLError = rclpy_implementation.RCLError
_NUMBERS = re.compile(r"[\d.]+")


def _keeps_apart(policy: str, publisher: TopicEndpointInfo, subscription: TopicEndpointInfo) -> bool:
    """Whether this policy alone keeps the subscription from hearing the publisher."""
    ends = publisher.qos_profile, subscription.qos_profile
    alone = (QoSProfile(depth=1, **{policy: getattr(profile, policy)}) for profile in ends)
    return qos_check_compatible(*alone)[0] == QoSCompatibility.ERROR


class SuiteNode(LifecycleNode, Generic[Config]):
    """A lifecycle node that configures and activates itself unless `autostart` is false.

    `lock` guards what `start`, `stop`, `health` and other threads than the executor's share.
    """

    def __init__(self, name: str, config_class: type[Config], namespace: str = "vsa", **defaults: Any) -> None:
        """`defaults` hold for parameters that nobody gives a value."""
        self._unheard: dict[Publisher | Subscription, str] = {}  # our end: policies that keep another node apart
        self._compared = 0
        try:
            super().__init__(name, namespace=namespace, automatically_declare_parameters_from_overrides=True)
        except ValueError as error:  # rcl gives an empty list no type
            raise ConfigurationError(
                f"{name}: a parameter has no value; write an empty list as ['']: {error}"
            ) from error
        self.steady = Clock(clock_type=ClockType.STEADY_TIME)  # one for all nodes of a process gets slow
        self._config_class = config_class
        self._defaults = defaults
        self.lock = threading.RLock()
        self._reported_last: tuple[int, str, float] = (OK, "", 0.0)
        self._active = False
        self._starting = False
        self.failure = ""
        try:
            self.config = self._declare()
        except ConfigurationError as error:
            raise ConfigurationError(f"{self.get_name()}: {error}") from error
        self.add_on_set_parameters_callback(self._on_parameters)
        self._refuse_illegal_transitions()
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_timer(LOOK, self._publish_health, clock=self.steady)

    # What a node of the suite provides.

    def start(self) -> None:
        """Begin to work: topics, timers, core. Raise ConfigurationError where that is impossible."""

    def stop(self) -> None:
        """Undo `start`. Called once for each successful `start`, also when the process ends."""

    def reconfigure(self, config: Config) -> None:
        """Take a checked configuration; raise ConfigurationError to refuse it. The old one is kept then."""
        if self._active:
            raise ConfigurationError("cannot change while the node is active; deactivate it first")

    def health(self) -> Health:
        """Level (OK, WARN, ERROR, STALE), one line, and key values for /diagnostics."""
        return OK, "active" if self._active else "inactive", {}

    # Topics whose policies do not fit are no mystery: the diagnostics name them. Not by rclpy's events: one that is
    # still queued for a topic that a transition has closed ends the process (ros2/rclpy#1644).

    def create_publisher(self, msg_type: Any, topic: str, qos_profile: Any, **options: Any) -> Any:
        events = PublisherEventCallbacks(use_default_callbacks=False)
        return super().create_publisher(msg_type, topic, qos_profile, event_callbacks=events, **options)

    def create_subscription(self, msg_type: Any, topic: str, callback: Any, qos_profile: Any, **options: Any) -> Any:
        events = SubscriptionEventCallbacks(use_default_callbacks=False)
        return super().create_subscription(msg_type, topic, callback, qos_profile, event_callbacks=events, **options)

    def _compare_policies(self) -> None:
        """Look whether everybody at one of our topics hears us, or is heard: the next one each time, as it costs."""
        ours: list[Publisher | Subscription] = [*self.publishers, *self.subscriptions]
        self._compared = (self._compared + 1) % len(ours)
        mine = ours[self._compared]
        known = self._unheard
        self._unheard = {one: known[one] for one in ours if one in known and one is not mine}
        if policies := self._misfit(mine):
            self._unheard[mine] = policies
            if known.get(mine) != policies:
                self.get_logger().warning(self._incompatible())

    def _misfit(self, mine: Publisher | Subscription) -> str:
        """Policies that keep somebody at this topic from hearing us, or from being heard; empty if all can."""
        topic = mine.topic_name
        if isinstance(mine, Publisher):
            all_hear = self.count_subscribers(topic) <= mine.get_subscription_count()
        else:
            all_hear = self.count_publishers(topic) <= mine.get_publisher_count()
        if all_hear:
            return ""
        us = self.get_name(), self.get_namespace()
        pairs = product(self.get_publishers_info_by_topic(topic), self.get_subscriptions_info_by_topic(topic))
        ours = [pair for pair in pairs if us in ((end.node_name, end.node_namespace) for end in pair)]
        apart = (policy for policy in _POLICIES if any(_keeps_apart(policy, *pair) for pair in ours))
        return ", ".join(apart).replace("_", " ")

    def _incompatible(self) -> str:
        said = (f"{one.topic_name}: another node's {policies} does not fit" for one, policies in self._unheard.items())
        return "; ".join(said)

    # Lifecycle.

    @property
    def active(self) -> bool:
        """Whether the node works at present."""
        return self._active

    def autostart(self) -> None:
        """Configure and activate, if the parameter says so; ConfigurationError where the node cannot start."""
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
            if not self._starting:  # `run` says it then
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

    def _refuse_illegal_transitions(self) -> None:
        """rclpy lets a transition that is impossible in the present state end the process: answer instead."""
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
        """Tell at once what is new, and everything once a second."""
        self._compare_policies()
        with self.lock:
            level, message, values = self.health()
        if self._unheard:
            message = self._incompatible() if level == OK else f"{message}; {self._incompatible()}"
            level = max(level, WARN)
        now, (told_level, told_words, told_at) = time.monotonic(), self._reported_last
        words = _NUMBERS.sub("", message)
        if (level, words) == (told_level, told_words) and now - told_at < REPORT - 0.5 * LOOK:
            return
        self._reported_last = level, words, now
        status = DiagnosticStatus(level=bytes([level]), name=self.get_fully_qualified_name(), message=message)
        status.values = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
        array = DiagnosticArray(status=[status])
        array.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(array)
