# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Bank of filters of the general transmission (multiple model; Bar-Shalom, Li and Kirubarajan, ch. 11).

All members run on the same steps. Their likelihoods give the probabilities of the mixture. At a few ages the bank
repeats all its steps from the prior, in slices, linearised at its own coefficients and at the more certain of its
motion and a smoothed one: an extended Kalman filter whose first gradients were wrong keeps a bias (iterated filter;
Jazwinski, 1970, ch. 8).
"""

import copy
import math

import numpy as np
from vsa_common.types import Array
from vsa_estimator.general.elastic_law import elastic_law, fitted_growth
from vsa_estimator.general.encoder_motion import EncoderMotion
from vsa_estimator.general.impedance import mixture
from vsa_estimator.general.models import MODELS, NESTED, SIMPLE, geometry_at, members_at, set_spring_prior, transferred
from vsa_estimator.general.records import IMPEDANCE, SPRING, STEP, Record, X
from vsa_estimator.general.repetition import Repetition, advance, follow, shift_geometry, shift_members, widen
from vsa_estimator.settings import Initial
from vsa_estimator.tuning.general import (
    MIN_GROWTH,
    REFUTATION,
    RELINEARIZATION_TIMES,
    REPEATED_TIME,
    SLOPE_STD,
    SMOOTHING_LAG,
    STORED_REST,
)


class Bank:
    """All members, their repetition, and the impedance of their mixture."""

    _geometry: Record  # (1,) GEOMETRY, from the first step on

    def __init__(self, initial: Initial, rate: float) -> None:
        """`initial` coefficients of the prior; `rate` of the filter [Hz]."""
        self._initial = initial
        self._buffer = np.zeros(int(REPEATED_TIME * rate) + 1, STEP)
        self._lag = round(SMOOTHING_LAG * rate)
        self.restart()

    def restart(self) -> None:
        """Drop all data; the next step is the first."""
        self._members: Record | None = None
        self.impedance: Record = np.zeros(1, IMPEDANCE)
        self.force_nis: float | None = None  # NIS of the last force in the most probable member; None without one
        self._encoder = EncoderMotion()
        self._probabilities = np.full(len(MODELS), 1.0 / len(MODELS))
        self.age = 0.0  # time of motion with forces since the start [s]
        self._count, self._checks = 0, list(RELINEARIZATION_TIMES)
        self.repetitions = 0  # completed ones
        self._span = (math.inf, -math.inf)  # of the deflections [m]
        self._repetition: Repetition | None = None  # that is running

    def interrupt(self, dt: float, deflection: tuple[float, float], shift: tuple[float, float] = (0.0, 0.0)) -> None:
        """Reset the motion to a `deflection` [m] with its variance after a gap of dt [s]; the coefficients stay.

        `shift`: variances of a shift of encoder [m^2] and force sensor [N^2] within the gap.
        """
        if self._members is None:
            return
        self._encoder.restart(*deflection)
        gap = self._gap(dt, shift)
        advance(self._members, self._geometry, gap)
        self._mix(self._members)
        self._store(gap)

    def follow(self, dt: float, deflection: float) -> None:
        """Advance relaxation and hysteresis over dt [s] to a deflection [m]; nothing else changes."""
        if self._members is not None:
            follow(self._members, self._geometry, deflection, dt)

    def take_memory(self, other: "Bank") -> None:
        """Take relaxation and hysteresis, which follow the deflection alone, from a bank of the same data and later."""
        if self._members is not None and other._members is not None:
            for name in ("relaxation", "stop", "deflection"):
                self._members[name] = other._members[name]

    def copied(self) -> "Bank":
        """The bank without a running repetition. Only one of the two may go on: they share the stored steps."""
        other, shared = copy.copy(self), self._buffer
        other._buffer, other._repetition = np.zeros(0, STEP), None
        other = copy.deepcopy(other)
        other._buffer = shared
        return other

    def shift(self, deflection: float, force: float = 0.0) -> None:
        """Shift the law: encoder and force sensor read `deflection` [m] and `force` [N] more from now on."""
        if self._members is None:
            return
        shift_geometry(self._geometry, deflection)
        for members in (self._members, self._prior):
            shift_members(members, deflection, force)
        if self._repetition is not None:
            self._repetition.shift(deflection, force)
        self._buffer["deflection"] += deflection
        self._buffer["encoder"]["mean"][:, X] += deflection
        self._buffer["force"] += force
        self._span = self._span[0] + deflection, self._span[1] + deflection

    def exclude_exponential(self) -> None:
        """Give the exponential law the probability zero until the next start."""
        if self._members is None:
            return
        self._members["model"]["ln_prior"][0] = self._prior["model"]["ln_prior"][0] = -math.inf
        if self._repetition is not None:
            self._repetition.members["model"]["ln_prior"][0] = -math.inf

    def step(self, dt: float, deflection: tuple[float, float], force: tuple[float, float]) -> None:
        """One step dt [s] after the last; `deflection` [m] and `force` [N] with their variances, NaN for no force."""
        if self._members is None:
            self._start(deflection, force)
            return
        self._encoder.add(dt, *deflection)
        step = np.zeros(1, STEP)
        step["dt"], step["deflection"], step["deflection_variance"] = dt, deflection[0], deflection[1]
        self._encoder.write(step["encoder"])
        step["force"], step["force_variance"] = math.nan if self._encoder.is_onset else force[0], force[1]
        advance(self._members, self._geometry, step)
        self._span = min(self._span[0], deflection[0]), max(self._span[1], deflection[0])
        self._mix(self._members)
        self.age += dt if self.force_nis is not None else 0.0
        self._store(step)

    @property
    def is_repeating(self) -> bool:
        """Whether a repetition is running."""
        return self._repetition is not None

    def repeat_slice(self) -> None:
        """Do one slice of the running repetition; at its end its members replace the live ones."""
        if self._repetition and self._repetition.advance(self._buffer[: self._count], 0.5 * sum(self._span)):
            self.repetitions += 1
            self._members, self._geometry = self._repetition.members, self._repetition.geometry
            self._repetition = None
            self._mix(self._members)

    @property
    def exponential_evidence(self) -> float:
        """Log likelihood of the exponential law relative to the best member, not below -MAX_EVIDENCE."""
        return float(self._members["ln_likelihood"][0]) if self._members is not None else 0.0

    @property
    def exponential_probability(self) -> float:
        """Probability of the exponential law."""
        return float(self._probabilities[0])

    @property
    def exponential_spring_evidence(self) -> float:
        """Log likelihood of the better member with an exponential spring, relative to the best of all."""
        return max(float(self._members["ln_likelihood"][m]) for m in NESTED) if self._members is not None else 0.0

    def plausible(self) -> list[int]:
        """Indices of the members but the exponential law, the most probable one first.

        The others are not refuted, and neither drift faster nor relax unless that does: both explain a slow fault.
        """
        assert self._members is not None
        order = 1 + np.argsort(-self._probabilities[1:], kind="stable")
        permitted, models = self._members["ln_likelihood"] > -REFUTATION, self._members["model"]
        for name in ("level_density", "scale_density", "rate_density", "relaxation"):
            permitted &= models[name] <= models[name][order[0]]
        return [int(m) for m in order if permitted[m] or m == order[0]]

    def member(self, index: int) -> tuple[Record, Record]:
        """Copies of a member, (1,) MEMBER, and of its (1,) GEOMETRY, after the first step."""
        assert self._members is not None
        return self._members[index : index + 1].copy(), self._geometry.copy()

    def widen(self, ln_stiffness_variance: float) -> None:
        """Add a change of the whole elastic law of this relative variance, in all members."""
        if self._members is not None:
            widen(self._members, self._geometry, ln_stiffness_variance)

    def elastic_law(self) -> tuple[Array, Array, Array, float] | None:
        """Elastic law of the mixture, see `vsa_estimator.general.elastic_law`; None before the second step."""
        if self._members is None or self._span[0] > self._span[1]:
            return None
        return elastic_law(self._members, self._geometry, self._probabilities, self._span)

    @property
    def description(self) -> str:
        """The most probable model, with its probability."""
        best = int(np.argmax(self._probabilities))
        return f"{MODELS[best].name} ({100.0 * self._probabilities[best]:.0f} %)"

    def _start(self, deflection: tuple[float, float], force: tuple[float, float]) -> None:
        if math.isnan(force[0]):
            return
        x, variance = deflection
        self._geometry = geometry_at(self._initial, x, self._initial.k2)
        self._members = members_at(self._initial, self._geometry, force[0], variance)
        self._prior = self._members.copy()  # of repetitions
        self._encoder.restart(x, variance)

    def _mix(self, members: Record) -> None:
        """Renew probabilities, impedance and NIS."""
        best = members[mixture(members, self._geometry, self._probabilities, self.impedance)]
        variance = float(best["innovation_variance"])
        self.force_nis = float(best["innovation"]) ** 2 / variance if variance > 0.0 else None

    def _gap(self, dt: float, shift: tuple[float, float] = (0.0, 0.0)) -> Record:
        """(1,) STEP without data, over dt [s] to the motion of the encoder; `shift` as in `interrupt`."""
        step = np.zeros(1, STEP)
        step["gap"], step["dt"], step["deflection_variance"], step["force_variance"] = True, dt, *shift
        self._encoder.write(step["encoder"])
        return step

    def _store(self, step: Record) -> None:
        """Keep a step for repetitions, and begin one that is due. A long rest is one gap."""
        if not self._checks and self._repetition is None:
            return
        if not step["gap"][0] and self._encoder.rest_time > STORED_REST:
            step = self._gap(float(step["dt"][0]))
        if step["gap"][0] and self._count and self._buffer["gap"][self._count - 1]:
            self._count -= 1
            for name in ("dt", "deflection_variance", "force_variance"):
                step[name] += self._buffer[name][self._count]
        if self._count == len(self._buffer):
            self._checks.clear()
            self._repetition = None
            return
        self._buffer[self._count] = step[0]
        self._count += 1
        if self._checks and self._repetition is None and self.age >= self._checks[0] and self._members is not None:
            self._checks.pop(0)
            reference, growth = float(self._geometry["reference"][0]), self._growth()
            geometry = geometry_at(self._initial, reference, growth, self._span)
            set_spring_prior(self._prior, geometry)
            coefficients = self._members["mean"].copy()
            coefficients[:, SPRING:] = transferred(coefficients[:, SPRING:], self._geometry, geometry)
            self._repetition = Repetition(self._prior, coefficients, geometry, self._lag)

    def _growth(self) -> float:
        """kappa [1/m] of the exponential law that fits the elastic law of the most probable simple member best."""
        assert self._members is not None
        best = SIMPLE.start + int(np.argmax(self._probabilities[SIMPLE]))
        law = elastic_law(self._members[best : best + 1], self._geometry, np.ones(1), self._span)
        k2 = self._initial.k2
        return max(fitted_growth(*law[:3], (k2, SLOPE_STD * k2)), MIN_GROWTH * k2)
