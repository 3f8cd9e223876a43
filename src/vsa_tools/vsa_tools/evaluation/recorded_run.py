"""What a bag holds of a run, as the arrays that `summary` judges."""

from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
from vsa_common.io.bags import read
from vsa_common.stamps import nanoseconds
from vsa_tools.evaluation.summary import Coefficient, Floats, Frames, Integers, JointRun, Series, Transmission
from vsa_tools.topics import TRANSMISSIONS

COEFFICIENTS = ("k2", "d2", "inertia")
Values = dict[str, float]


class Recorded:
    """The suite's topics of one namespace of a bag. Raises BagError where it cannot be read."""

    def __init__(self, bag: Path, namespace: str = "/vsa") -> None:
        of_side = ("capture_counters", "impedance", "estimator_state")
        wanted = [f"{namespace}/{side}/{topic}" for side in TRANSMISSIONS for topic in of_side]
        self._joint = f"{namespace}/joint_impedance"
        self._space = namespace
        self._rows: dict[str, list[tuple[float, ...]]] = defaultdict(list)
        self._stamps: dict[str, list[int]] = defaultdict(list)
        self._last_state: dict[str, Any] = {}
        for topic, _, message in read(bag, [*wanted, self._joint]):
            self._take(topic, message)

    def _take(self, topic: str, message: Any) -> None:
        if topic.endswith("capture_counters"):
            self._stamps[topic] += [nanoseconds(stamp) for stamp in message.stamp]
            self._rows[topic] += [(int(counter),) for counter in message.counter]
        elif topic.endswith("estimator_state"):
            self._last_state[topic] = message
        else:
            stamps = message.transmission_stamp if topic == self._joint else [message.header.stamp]
            self._stamps[topic] += [nanoseconds(stamp) for stamp in stamps]
            impedance = (message.stiffness, message.stiffness_variance, message.damping, message.damping_variance)
            self._rows[topic].append(impedance)

    def frames(self, side: str) -> Frames:
        """Which sample each capture stamp of a transmission belongs to."""
        topic = f"{self._space}/{side}/capture_counters"
        stamps = np.array(self._stamps[topic], dtype=np.int64)
        counters = np.array(self._rows[topic], dtype=np.int64).reshape(-1)
        order = np.argsort(stamps, kind="stable")
        return Frames(stamps[order], counters[order])

    def transmission(self, side: str, start: Values, truth: Values) -> Transmission:
        """One transmission, with the start values and the true values of its coefficients."""
        topic = f"{self._space}/{side}/impedance"
        stiffness, damping = self._series(topic)
        state = self._last_state.get(f"{self._space}/{side}/estimator_state")
        coefficients = {name: _coefficient(state, name, start, truth) for name in COEFFICIENTS}
        sample = self.frames(side).samples(np.array(self._stamps[topic], dtype=np.int64))
        fused, inertia_valid = (int(state.samples_fused), bool(state.inertia_valid)) if state else (0, False)
        return Transmission(fused, sample, stiffness, damping, coefficients, inertia_valid)

    def joint(self) -> JointRun:
        """The joint."""
        stamps: Integers = np.array(self._stamps[self._joint], dtype=np.int64).reshape(-1, 2)
        first, second = (self.frames(side).samples(stamps[:, i]) for i, side in enumerate(TRANSMISSIONS))
        return JointRun((first, second), *self._series(self._joint))

    def _series(self, topic: str) -> tuple[Series, Series]:
        rows: Floats = np.array(self._rows[topic], dtype=float).reshape(-1, 4)
        rows[:, [1, 3]] = np.sqrt(np.maximum(rows[:, [1, 3]], 0.0))
        return Series(rows[:, 0], rows[:, 1]), Series(rows[:, 2], rows[:, 3])


def _coefficient(state: Any, name: str, start: Values, truth: Values) -> Coefficient:
    estimate, variance = (getattr(state, name), getattr(state, f"{name}_variance")) if state else (np.nan, np.nan)
    return Coefficient(start[name], float(estimate), float(np.sqrt(variance)), truth[name])
