# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Recordings on which the constants are varied: cases of `bench estimation`, sensor faults, changed coefficients."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from vsa_bench.estimation.cases import DEFAULT, Case, case
from vsa_bench.estimation.recordings import record
from vsa_bench.estimation.starts import draw
from vsa_common.types import Array, Booleans
from vsa_simulator.faults.recorded import delayed, with_failure, with_pauses

SEED = 11
SECONDS = 60.0  # of each case without --quick
FAULTS = "sensor faults"
FAULTS_SECONDS = 16.0  # of the recording with sensor faults
STEP = "encoder step"
STEP_SECONDS = 16.0  # of the recording with an encoder step
DRIFT = "force drift"
DRIFT_SECONDS = 20.0  # of the recording with a drift of the force
SINGLE_FAULT_CASE = case(motion="multisine", start="good")
FAULTY_CASE = case(motion="multisine", rate_hz=200, start="good")
CHANGE = "change of the transmission"
CHANGED_SECONDS = 16.0  # of the recording in which another transmission replaces the first
CHANGED_CASES = tuple(case(motion="slow2", start="good", rig=rig) for rig in ("paper", "other"))
QUICK = (
    (case(motion="multisine"), 20.0),
    (case("transmission_2", "slow2"), 15.0),
    (case(motion="dwells"), 20.0),
    (case(motion="slow", coulomb_friction_n=0.0, start="good"), 15.0),
)
# Failures of the recording with sensor faults; begin as a share of it, duration in s.
FORCE_FAILURES = (("force spike -v 1.7", 0.30, 0.0), ("force noise -v 10", 0.55, 1.0), ("force stuck", 0.65, 1.0))
ENCODER_FAILURES = (
    ("encoder spike -v 0.001", 0.32, 0.0), ("encoder noise -v 10", 0.35, 1.0), ("encoder stuck", 0.45, 1.0)
)  # fmt: skip


Kind = TypeVar("Kind", bound="Recording")


@dataclass(frozen=True)
class Recording:
    """Samples of one transmission, the parameters of its estimator, and the truth at each sample, SI."""

    name: str
    parameters: Mapping[str, object]
    stamps_ns: NDArray[np.int64]
    force: Array
    deflection: Array
    stiffness: Array
    damping: Array
    damping_defined: Booleans  # below the peak speed of the damper
    instants_ns: NDArray[np.int64]  # of the samples; the stamps may be later

    @property
    def time(self) -> Array:
        """Time since the first sample [s]."""
        return np.asarray(1e-9 * (self.stamps_ns - self.stamps_ns[0]))

    def selected(self: Kind, kept: Booleans) -> Kind:
        """The samples at which `kept` is true."""
        return replace(
            self, stamps_ns=self.stamps_ns[kept], force=self.force[kept], deflection=self.deflection[kept],
            stiffness=self.stiffness[kept], damping=self.damping[kept], damping_defined=self.damping_defined[kept],
            instants_ns=self.instants_ns[kept],
        )  # fmt: skip


def recordings(quick: bool, seconds: float | None) -> Iterator[Recording]:
    """The recordings of the bench, each of its own length or of `seconds` [s]."""
    for one, usual in QUICK if quick else ((one, SECONDS) for one in DEFAULT):
        # The force_rate formulation has constants of its own; it requires good start values and little friction.
        both = ("force_rate",) if quick else ("force", "force_rate")
        for formulation in both if one.start == "good" else ("force",):
            yield simulated(one, formulation, seconds or usual)
    yield with_sensor_faults(simulated(FAULTY_CASE, "force", seconds or FAULTS_SECONDS))
    yield with_encoder_step(simulated(SINGLE_FAULT_CASE, "force", seconds or STEP_SECONDS))
    yield with_force_drift(simulated(SINGLE_FAULT_CASE, "force", seconds or DRIFT_SECONDS))
    yield with_change(*(simulated(one, "force", seconds or CHANGED_SECONDS) for one in CHANGED_CASES))


def simulated(one: Case, formulation: str, seconds: float) -> Recording:
    """One case with the start values of one seed."""
    source = record(one, [SEED], seconds)
    truth = source.truth
    start = draw(one, float(truth.deflection[0]), SEED)
    parameters = {"formulation": formulation} | source.noise_parameters() | start.parameters()
    return Recording(
        one.label + (" force_rate" if formulation == "force_rate" else ""), parameters, source.stamps_ns,
        source.force[0], source.deflection[0], truth.stiffness, truth.damping,
        damping_defined=np.abs(truth.velocity) < truth.coefficients.maximum_speed, instants_ns=source.stamps_ns,
    )  # fmt: skip


def with_sensor_faults(healthy: Recording) -> Recording:
    """Late stamps throughout; a burst, outliers, noise, stuck sensors and gaps at shares of the recording."""
    count, rate = len(healthy.stamps_ns), round(1e9 / float(np.median(np.diff(healthy.stamps_ns))))

    def window(begin: float, seconds: float) -> range:
        first = round(begin * count)
        return range(first, min(first + max(1, round(seconds * rate)), count))

    burst = window(0.25, 0.08)
    stamps_ns = with_pauses(
        delayed(healthy.stamps_ns, np.random.default_rng(SEED)),
        healthy.stamps_ns[[burst.start]],
        np.array([80_000_000]),
    )
    force, deflection = healthy.force, healthy.deflection
    for failure, begin, seconds in FORCE_FAILURES:
        force = with_failure(force, failure, window(begin, seconds), rate, SEED)
    for failure, begin, seconds in ENCODER_FAILURES:
        deflection = with_failure(deflection, failure, window(begin, seconds), rate, SEED)
    received = np.ones(count, dtype=np.bool_)
    received[window(0.75, 0.3)] = received[window(0.85, 0.7)] = False
    faulty = replace(healthy, name=FAULTS, stamps_ns=stamps_ns, force=force, deflection=deflection)
    return faulty.selected(received)


def with_encoder_step(healthy: Recording) -> Recording:
    """The encoder is off by 1 mm from the middle on."""
    stepped = np.arange(len(healthy.force)) >= len(healthy.force) // 2
    return replace(healthy, name=STEP, deflection=healthy.deflection + 1e-3 * stepped)


def with_force_drift(healthy: Recording) -> Recording:
    """The force drifts by 2 N from the middle on, during a fifth of the recording, and stays off."""
    share = np.arange(len(healthy.force)) / len(healthy.force)
    return replace(healthy, name=DRIFT, force=healthy.force + 2.0 * np.clip((share - 0.5) / 0.2, 0.0, 1.0))


def with_change(first: Recording, second: Recording) -> Recording:
    """`first` up to its middle, then the samples of another transmission: the coefficients become wrong."""
    changed = np.arange(len(first.force)) >= len(first.force) // 2
    force, deflection, stiffness, damping = (
        np.where(changed, getattr(second, name), getattr(first, name))
        for name in ("force", "deflection", "stiffness", "damping")
    )
    defined = np.where(changed, second.damping_defined, first.damping_defined)
    return replace(
        first, name=CHANGE, force=force, deflection=deflection, stiffness=stiffness, damping=damping,
        damping_defined=defined,
    )  # fmt: skip
