"""Parameters as ROS declares them, and the parameters that every node has."""

import math
from dataclasses import dataclass
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from vsa_common.config.configuration import Parameter, flag, group, parameters
from vsa_common.ros.realtime import RealTime

_OF_ROS = ("use_sim_time", "start_type_description_service")


@dataclass(frozen=True)
class Common:
    """Parameters that every node has; read at its start."""

    autostart: bool = flag(True, "configure and activate at start")
    realtime: RealTime = group(RealTime)


COMMON = {parameter.name for parameter in parameters(Common)}


def is_ours(name: str) -> bool:
    """Whether a parameter belongs to the suite and not to ROS."""
    return name not in _OF_ROS and not name.startswith("qos_overrides.")


def ros_value(value: Any) -> Any:
    """A value in a type of ROS: a tuple becomes a list."""
    return list(value) if isinstance(value, tuple) else value


def descriptor(parameter: Parameter) -> ParameterDescriptor:
    """Descriptor with meaning, unit and range."""
    unit = f" [{parameter.unit}]" if parameter.unit else ""
    result = ParameterDescriptor(description=f"{parameter.text}{unit}", dynamic_typing=True)
    if parameter.options:
        result.additional_constraints = "one of " + ", ".join(parameter.options)
    if math.isfinite(parameter.low) and math.isfinite(parameter.high) and not isinstance(parameter.default, tuple):
        if parameter.kind is float:
            limits = FloatingPointRange(from_value=float(parameter.low), to_value=float(parameter.high))
            result.floating_point_range = [limits]
        elif parameter.kind is int:
            result.integer_range = [IntegerRange(from_value=int(parameter.low), to_value=int(parameter.high))]
    return result
