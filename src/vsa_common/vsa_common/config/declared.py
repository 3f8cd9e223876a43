"""Parameters as ROS declares them, and those that every node has."""

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
    """Whether a parameter is the suite's, not one that ROS gives every node."""
    return name not in _OF_ROS and not name.startswith("qos_overrides.")


def ros_value(value: Any) -> Any:
    """A value as ROS takes it."""
    return list(value) if isinstance(value, tuple) else value


def descriptor(parameter: Parameter) -> ParameterDescriptor:
    """What ROS tells of a parameter: meaning, unit and range."""
    unit = f" [{parameter.unit}]" if parameter.unit else ""
    told = ParameterDescriptor(description=f"{parameter.text}{unit}", dynamic_typing=True)
    if parameter.options:
        told.additional_constraints = "one of " + ", ".join(parameter.options)
    if math.isfinite(parameter.low) and math.isfinite(parameter.high) and not isinstance(parameter.default, tuple):
        if parameter.kind is float:
            limits = FloatingPointRange(from_value=float(parameter.low), to_value=float(parameter.high))
            told.floating_point_range = [limits]
        elif parameter.kind is int:
            told.integer_range = [IntegerRange(from_value=int(parameter.low), to_value=int(parameter.high))]
    return told
