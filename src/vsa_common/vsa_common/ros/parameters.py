# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parameters of a node: declared with type, unit and range from a configuration class, and checked at each change."""

import math
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar, cast

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter
from vsa_common.config.configuration import (
    ConfigurationError,
    Parameter,
    build,
    flag,
    flatten,
    group,
    parameter_files,
    parameters,
)
from vsa_common.config.sections import sections_of, shared_names
from vsa_common.ros.realtime import RealTime

_OF_ROS = ("use_sim_time", "start_type_description_service")

Config = TypeVar("Config")


@dataclass(frozen=True)
class Common:
    """Parameters that every node has; read at its start."""

    autostart: bool = flag(True, "configure and activate at start")
    realtime: RealTime = group(RealTime)


COMMON = {parameter.name: parameter for parameter in parameters(Common)}


class NodeParameters(Generic[Config]):
    """Declared parameters of a node, as the configurations `common` and `config`.

    A change has the declared type: an integer for a double and a text such as 1e-3 are converted first. Parameters of
    `Common` are read-only. While `is_active` returns True only tunable parameters change. `apply` gets each changed
    configuration before it is stored, and raises ConfigurationError to reject it.
    """

    def __init__(
        self,
        node: Node,
        config_class: type[Config],
        defaults: Mapping[str, Any],
        is_active: Callable[[], bool],
        apply: Callable[[Config], None],
    ) -> None:
        """Declare all parameters. Raises ConfigurationError for an unknown one or a bad value.

        `defaults` replace those of `config_class`. A parameter given for nodes of any name that this one does not
        have is ignored with a warning.
        """
        self._node = node
        self._is_active, self._apply = is_active, apply
        self._own = {parameter.name: parameter for parameter in parameters(config_class)}
        given = self._given()
        self.common = build(Common, {name: value for name, value in given.items() if name in COMMON})
        own = {name: value for name, value in given.items() if name not in COMMON}
        self.config = build(config_class, {**defaults, **own})
        for one, declared in ((self.config, self._own), (self.common, COMMON)):
            values = flatten(one)
            for parameter in declared.values():
                self._declare(parameter, values[parameter.name], read_only=declared is COMMON)
        node.add_pre_set_parameters_callback(self._convert)
        node.add_on_set_parameters_callback(self._check)

    def _given(self) -> dict[str, Any]:
        """Values of parameter files and command line, without those of ROS and those of other nodes."""
        node = self._node
        overrides = cast("Mapping[str, RosParameter]", node.get_parameters_by_prefix(""))
        given = {name: override.value for name, override in overrides.items() if is_ours(name)}
        unknown = given.keys() - self._own.keys() - COMMON.keys()
        if unknown:
            files = parameter_files(sys.argv)
            name = node.get_fully_qualified_name()
            unknown &= {one for path in files for one in shared_names(sections_of(path, name))}
        for name in sorted(unknown):
            del given[name]
            node.undeclare_parameter(name)
            node.get_logger().warning(f"{name}: given for all nodes, no parameter of this one; ignored")
        return given

    def _declare(self, parameter: Parameter, value: Any, read_only: bool) -> None:
        name = parameter.name
        if self._node.has_parameter(name):
            self._node.undeclare_parameter(name)
        self._node.declare_parameter(name, ros_value(value), descriptor(parameter, read_only), ignore_override=True)

    def _convert(self, changes: list[RosParameter]) -> list[RosParameter]:
        """Changes in their declared types where that is possible; ROS refuses the others by their type."""
        return [self._in_declared_type(change) for change in changes]

    def _in_declared_type(self, change: RosParameter) -> RosParameter:
        parameter = self._own.get(change.name)
        if parameter is None or change.value is None:
            return change
        try:
            value = ros_value(parameter.convert(change.value))
        except ConfigurationError:
            return change
        return RosParameter(change.name, self._node.get_parameter(change.name).type_, value)

    def _check(self, changes: Sequence[RosParameter]) -> SetParametersResult:
        before = flatten(self.config)
        ours = {change.name: change.value for change in changes if change.name in self._own}
        try:
            config = build(type(self.config), {**before, **ours})
            changed = [name for name, value in flatten(config).items() if value != before[name]]
            if changed:
                self._reject_fixed(changed)
                self._apply(config)
        except ConfigurationError as error:
            return SetParametersResult(successful=False, reason=str(error))
        self.config = config
        return SetParametersResult(successful=True)

    def _reject_fixed(self, changed: Sequence[str]) -> None:
        """Raise ConfigurationError for a parameter that is fixed while the node is active."""
        fixed = [name for name in changed if not self._own[name].tunable]
        if fixed and self._is_active():
            node = self._node.get_fully_qualified_name()
            raise ConfigurationError(
                f"{fixed[0]} cannot change while the node is active: `ros2 lifecycle set {node} deactivate`, "
                f"set the parameter, `ros2 lifecycle set {node} activate`"
            )


def is_ours(name: str) -> bool:
    """Whether a parameter belongs to the suite and not to ROS."""
    return name not in _OF_ROS and not name.startswith("qos_overrides.")


def ros_value(value: Any) -> Any:
    """A value in a type of ROS: a tuple becomes a list."""
    return list(value) if isinstance(value, tuple) else value


def descriptor(parameter: Parameter, read_only: bool = False) -> ParameterDescriptor:
    """Descriptor with meaning, unit, range, and when it can be changed."""
    unit = f" [{parameter.unit}]" if parameter.unit else ""
    result = ParameterDescriptor(description=f"{parameter.text}{unit}", read_only=read_only)
    constraints = ["one of " + ", ".join(parameter.options)] if parameter.options else []
    if not read_only:
        constraints.append("changes at any time" if parameter.tunable else "changes while the node is not active")
    result.additional_constraints = "; ".join(constraints)
    if math.isfinite(parameter.low) and math.isfinite(parameter.high) and not isinstance(parameter.default, tuple):
        if parameter.kind is float:
            limits = FloatingPointRange(from_value=float(parameter.low), to_value=float(parameter.high))
            result.floating_point_range = [limits]
        elif parameter.kind is int:
            result.integer_range = [IntegerRange(from_value=int(parameter.low), to_value=int(parameter.high))]
    return result
