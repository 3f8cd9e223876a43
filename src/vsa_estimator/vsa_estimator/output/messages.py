# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Estimates and states as serialized messages; fields are taken by the names in the message definitions."""

from collections.abc import Iterator
from operator import itemgetter
from typing import Any

from std_msgs.msg import Header
from vsa_common.ros.cdr import Writer
from vsa_estimator.output.estimate import Estimate, State
from vsa_msgs.msg import EstimatorState, TransmissionImpedance


def _fields(message: Any) -> list[str]:
    return [name for name in message.get_fields_and_field_types() if name != "header"]


impedance_fields = itemgetter(*(Estimate._fields.index(name) for name in _fields(TransmissionImpedance)))

_TEXTS = ("reason", "observability", "elastic_law")
_SEQUENCES = ("elastic_deflection", "elastic_ln_stiffness", "elastic_ln_stiffness_covariance")
_NUMBERS = [name for name in _fields(EstimatorState) if name not in _TEXTS]


class ImpedanceWriter:
    """Serialized TransmissionImpedance messages of one transmission."""

    def __init__(self, frame_id: str) -> None:
        self._writer = Writer(TransmissionImpedance(header=Header(frame_id=frame_id)))

    def write(self, estimate: Estimate) -> bytes:
        """The message of an estimate."""
        return self._writer.write(estimate.stamp_ns, impedance_fields(estimate))


class StateWriter:
    """Serialized EstimatorState messages of one transmission."""

    def __init__(self, frame_id: str) -> None:
        self._frame_id = frame_id
        self._template: dict[str, Any] = {}  # what the writer's template has
        self._writer: Writer

    def write(self, stamp_ns: int, state: State) -> bytes:
        """The message of a state at a stamp [ns]."""
        template: dict[str, Any] = {name: getattr(state, name) for name in _TEXTS}
        template |= {name: [0.0] * len(getattr(state, name)) for name in _SEQUENCES}
        template["observability"] = list(state.observability)
        if template != self._template:
            self._template = template
            self._writer = Writer(EstimatorState(header=Header(frame_id=self._frame_id), **template))
        return self._writer.write(stamp_ns, list(_numbers(state)))


def _numbers(state: State) -> Iterator[Any]:
    """Numbers of a state in the order of the message; a sequence begins with its length."""
    for name in _NUMBERS:
        value = getattr(state, name)
        if name in _SEQUENCES:
            yield len(value)
        yield from value if isinstance(value, tuple) else (value,)
