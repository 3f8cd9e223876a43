# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Goal and quantities of the action Excite as records."""

import math

from vsa_joint.excitation.procedure import ExcitationRefused
from vsa_joint.excitation.quantities import DEFAULT, UNITS, QuantityEstimate
from vsa_joint.excitation.settings import ExcitationConfig, Goal
from vsa_msgs.action import Excite
from vsa_msgs.msg import QuantityEstimate as QuantityMessage


def goal_of(request: Excite.Goal, config: ExcitationConfig) -> Goal:
    """The goal with the parameters for what it omits. Raises ExcitationRefused for a bad value."""
    quantities = tuple(dict.fromkeys(request.quantities)) or DEFAULT
    if unknown := [name for name in quantities if name not in UNITS]:
        raise ExcitationRefused(f"no quantity {', '.join(unknown)}; there are {', '.join(UNITS)}")
    for name in ("relative_interval", "duration", "travel", "speed", "tension"):
        value = getattr(request, name)
        if not (math.isfinite(value) and value >= 0.0):
            raise ExcitationRefused(f"{name} = {value:g}: must be a number of at least 0")
    return Goal(
        quantities,
        request.relative_interval,
        duration=min(request.duration or config.duration, config.duration),
        travel=min(request.travel or config.travel, config.travel),
        speed=min(request.speed or config.speed, config.speed),
        force_max=min(2.0 * request.tension or config.force_max, config.force_max),
    )


def message_of(one: QuantityEstimate) -> QuantityMessage:
    """The message of an estimate."""
    return QuantityMessage(
        transmission=f"transmission_{one.transmission}",
        quantity=one.quantity,
        unit=UNITS[one.quantity],
        value=float(one.value),
        standard_deviation=float(one.std),
        known=one.known_after is not None,
        known_after=-1.0 if one.known_after is None else one.known_after,
    )
