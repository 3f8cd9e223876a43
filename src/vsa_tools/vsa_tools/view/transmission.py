# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""State of one transmission on the live page, from serialized messages."""

import math
from collections.abc import Mapping
from typing import Any

from vsa_common.ros.cdr import Reader, read_counters, read_stamp
from vsa_common.types import ResetReason
from vsa_estimator.force_rate.rate_filter import RateFilter
from vsa_estimator.modes import Mode
from vsa_tools.view.events import CounterWatch, Events
from vsa_tools.view.section import Section
from vsa_tools.view.time_series import Stream, count_lost, quantity, rounded

MAX_STEP_S = 1.0  # [s] a longer step between samples restarts the force rate: its filter has settled by then

_WITH_VARIANCE = ("velocity", "acceleration", "stiffness", "damping", "inertia")
_QUANTITIES = ("force", "deflection", *_WITH_VARIANCE)
_FIELDS = (
    *_QUANTITIES,
    *(f"{name}_variance" for name in _WITH_VARIANCE),
    *(f"{name}_valid" for name in _QUANTITIES),
)
CURVES = ("force_rate", *(name.replace("_variance", "_std") for name in _FIELDS))
_COEFFICIENTS = ("k2", "d1", "d2", "inertia", "force_offset", "coulomb_friction")
_COUNTS = ("samples_fused", "samples_dropped", "force_rejected", "deflection_rejected", "reset_count")
_COUNTER_EVENTS = {  # text of the event for an increment
    "samples_dropped": "sample dropped",
    "force_rejected": "force rejected by the gate",
    "deflection_rejected": "position rejected by the gate",
}
_RESETS = {reason.value: reason.name for reason in ResetReason}
_MODES = {mode.value: mode.name.lower().replace("_", " ") for mode in Mode}


class TransmissionSection(Section):
    """One transmission."""

    def __init__(self, name: str, reader: Reader, state_reader: Reader, events: Events) -> None:
        super().__init__(name, reader, events, _QUANTITIES, _FIELDS)
        self.stream = Stream(CURVES)
        self.sensor = Stream(("position", "residual"))
        self._state_reader = state_reader
        self._counter_watch = CounterWatch(name, events)
        self._state: dict[str, Any] = {}
        self._lost: tuple[int, int] | None = None  # newest counter, samples lost
        self._rate_filter, self._force_ns = RateFilter(), 0  # of the last force [ns]

    def add_impedance(self, data: bytes, now: float) -> None:
        """Add a serialized TransmissionImpedance at `now` [s] of a steady clock."""
        stamp_ns, numbers = self.add_impedance_message(data, now)
        self.stream.add(stamp_ns, (self._update_force_rate(stamp_ns, numbers[0]), *numbers))

    def add_state(self, data: bytes) -> None:
        """Add a serialized EstimatorState."""
        stamp_ns, values = self._state_reader.read(data)
        self._state = state = dict(zip(self._state_reader.names, values, strict=True))
        residual = state["deflection_innovation"]
        # The measured position without a subscription to the encoder's topic.
        self.sensor.add(stamp_ns, (state["deflection"] + residual, residual))
        for name, text in _COUNTER_EVENTS.items():
            self._counter_watch.update(text, state[name], stamp_ns)
        self._counter_watch.update("reset", state["reset_count"], stamp_ns, "error")

    def add_counters(self, data: bytes) -> None:
        """Add a serialized batch of CaptureCounters."""
        stamp_ns, (_, counters) = read_stamp(data), read_counters(data)
        self._lost = count_lost(counters, self._lost)
        self._counter_watch.update("sample lost on the bus", self._lost[1], stamp_ns, "error")

    def to_json(self, now: float) -> dict[str, Any]:
        """Everything of this transmission except its curves."""
        state = super().to_json(now)
        if self._state:
            state |= self._estimator_state(self.is_current(now))
        if self._lost is not None:
            state["lost"] = self._lost[1]
        return state

    def _estimator_state(self, current: bool) -> dict[str, Any]:
        state = self._state
        return {
            "coefficients": {
                name: quantity(*(state[name + end] for end in ("", "_variance", "_valid")), current=current)
                for name in _COEFFICIENTS
            },
            "elastic_law": _elastic_law(state, current),
            "reason": state["reason"] if current else "",
            "observability": state["observability"] if current else [],
            "reset_reason": _RESETS.get(state["reset_reason"], "UNKNOWN"),
            "mode": _MODES.get(state["mode"], "unknown") if current else "",
            **{name: state[name] for name in _COUNTS},
        }

    def _update_force_rate(self, stamp_ns: int, force: float) -> float:
        """Force rate [N/s] of the first-order filter after a sample; 0 after a gap."""
        dt, self._force_ns = 1e-9 * (stamp_ns - self._force_ns), stamp_ns
        if not 0.0 <= dt < MAX_STEP_S:
            self._rate_filter = RateFilter()
        return self._rate_filter.add(force, dt)


def _elastic_law(state: Mapping[str, Any], current: bool) -> dict[str, Any] | None:
    """Name, validity, and ln stiffness at knots [m] with the variances and the covariances of neighbours.

    None without a law: of an estimator of an older version, or before its first sample.
    """
    knots, ln_stiffness = state.get("elastic_deflection", ()), state.get("elastic_ln_stiffness", ())
    covariance, count = state.get("elastic_ln_stiffness_covariance", ()), len(knots)
    numbers = (*knots, *ln_stiffness, *covariance)
    if not (count > 1 and len(numbers) == count * (count + 2) and all(map(math.isfinite, numbers))):
        return None
    return {
        "name": state["elastic_law"],
        "valid": state["elastic_law_valid"] and current,
        "deflection": [rounded(x) for x in knots],
        "ln_stiffness": [rounded(x) for x in ln_stiffness],
        "variance": [rounded(covariance[i * (count + 1)]) for i in range(count)],
        "covariance": [rounded(covariance[i * (count + 1) + 1]) for i in range(count - 1)],
    }
