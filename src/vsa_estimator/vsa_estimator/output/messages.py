# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Estimates and states as serialized messages; fields are taken by the names in the message definitions."""

from operator import itemgetter
from typing import Any

from std_msgs.msg import Header
from vsa_common.ros.cdr import Writer
from vsa_estimator.output.estimate import Estimate, State
from vsa_msgs.msg import EstimatorState, TransmissionImpedance


def _fields(message: Any) -> list[str]:
    return [name for name in message.get_fields_and_field_types() if name != "header"]


impedance_fields = itemgetter(*(Estimate._fields.index(name) for name in _fields(TransmissionImpedance)))

_TEXTS = ("reason", "observability")
_NUMBERS = [name for name in _fields(EstimatorState) if name not in _TEXTS]
_MATRIX = _NUMBERS.index("coefficient_covariance")
_before_matrix = itemgetter(*(State._fields.index(name) for name in _NUMBERS[:_MATRIX]))
_after_matrix = itemgetter(*(State._fields.index(name) for name in _NUMBERS[_MATRIX + 1 :]))


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
        self._texts: tuple[str, tuple[str, ...]] = "", ()
        self._writer = self._new_writer()

    def write(self, stamp_ns: int, state: State) -> bytes:
        """The message of a state at a stamp [ns]."""
        texts = state.reason, state.observability
        if texts != self._texts:
            self._texts = texts
            self._writer = self._new_writer()
        numbers = *_before_matrix(state), *state.coefficient_covariance, *_after_matrix(state)
        return self._writer.write(stamp_ns, numbers)

    def _new_writer(self) -> Writer:
        reason, lines = self._texts
        return Writer(EstimatorState(header=Header(frame_id=self._frame_id), reason=reason, observability=list(lines)))
