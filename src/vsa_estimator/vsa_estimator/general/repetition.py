# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Steps of the members, and their repetition from the prior, linearised at the last estimate."""

import numpy as np
from vsa_common.accel import compiled
from vsa_common.types import Array
from vsa_estimator.general.basis import extrapolation
from vsa_estimator.general.correction import correct_deflection, correct_force, reset_motion
from vsa_estimator.general.elastic_law import nest
from vsa_estimator.general.encoder_motion import is_moving, smooth
from vsa_estimator.general.law import prefers_smoothed
from vsa_estimator.general.models import NESTED
from vsa_estimator.general.prediction import (
    add_scale_noise,
    add_shift_noise,
    advance_memory,
    drop_innovation,
    predict_member,
)
from vsa_estimator.general.records import MOTION, SPRING, L, Record, V, X
from vsa_estimator.tuning.filter import STATIONARY_TIME
from vsa_estimator.tuning.general import MAX_EVIDENCE, STEPS_PER_SLICE


@compiled
def advance_member(member: Record, geometry: Record, step: Record) -> None:
    """One step of a member, (1,) MEMBER."""
    one, now = member[0], step[0]
    predict_member(member, geometry, now["dt"], now["encoder"]["density"])
    if not correct_deflection(member, now["deflection"], now["deflection_variance"]):
        reset_motion(member, step["encoder"])
    x = now["smoothed"][X] if prefers_smoothed(member, step) else one["mean"][X]
    advance_memory(member, geometry, x, now["dt"])
    drop_innovation(member)
    moves = is_moving(one["mean"][V], one["covariance"][V, V])
    one["time_since_motion"] = 0.0 if moves else one["time_since_motion"] + now["dt"]
    if np.isnan(now["force"]) or one["time_since_motion"] >= STATIONARY_TIME or extrapolation(geometry, one["mean"][X]):
        return
    correct_force(member, geometry, step)


@compiled
def advance(members: Record, geometry: Record, step: Record) -> None:
    """One step of all members; their likelihoods stay within MAX_EVIDENCE of the best one, or -inf: it has diverged.

    In a gap the deflection changes at a constant rate.
    """
    now = step[0]
    if now["gap"]:
        for m in range(members.size):
            predict_member(members[m : m + 1], geometry, now["dt"], 0.0)
            reset_motion(members[m : m + 1], step["encoder"])
            advance_memory(members[m : m + 1], geometry, members[m]["mean"][X], now["dt"])
            drop_innovation(members[m : m + 1])
            add_shift_noise(members[m : m + 1], geometry, now["deflection_variance"], now["force_variance"])
        return
    best = -np.inf
    for m in range(members.size):
        advance_member(members[m : m + 1], geometry, step)
        if not np.isfinite(members[m]["ln_likelihood"]):
            members[m]["ln_likelihood"] = -np.inf
        best = max(best, members[m]["ln_likelihood"])
    for m in range(members.size):
        if np.isfinite(members[m]["ln_likelihood"]):
            members[m]["ln_likelihood"] = max(members[m]["ln_likelihood"] - best, -MAX_EVIDENCE)


@compiled
def follow(members: Record, geometry: Record, deflection: float, dt: float) -> None:
    """Advance relaxation and hysteresis of all members over dt [s] to a deflection [m]."""
    for m in range(members.size):
        advance_memory(members[m : m + 1], geometry, deflection, dt)


@compiled
def widen(members: Record, geometry: Record, variance: float) -> None:
    """Add a change of the whole elastic law of this relative variance to the covariance of all members."""
    for m in range(members.size):
        add_scale_noise(members[m : m + 1], geometry, variance)


@compiled
def repeat(members: Record, geometry: Record, steps: Record) -> None:
    """Advance all members through `steps`, (n,) STEP."""
    for i in range(steps.size):
        advance(members, geometry, steps[i : i + 1])


class Repetition:
    """A pass of all members through the stored steps, a slice at a time.

    The members with an exponential spring follow from the others at the end, one in a slice.
    """

    def __init__(self, prior: Record, coefficients: Array, geometry: Record, lag: int) -> None:
        """Begin at `prior` (n,) MEMBER with `coefficients` (n, SIZE) of the gradient.

        A motion is smoothed by the deflections of `lag` later steps.
        """
        self.members, self.geometry = prior.copy(), geometry
        self.members["linear"], self.members["driving"] = coefficients, coefficients[:, SPRING:]
        self._prior, self._lag = prior, lag
        self._first, self._done = len(NESTED), 0  # the first repeated member; repeated steps
        motion = prior[0]["mean"][:MOTION], prior[0]["covariance"][:MOTION, :MOTION]
        self._motion = motion[0][:, None].copy(), motion[1].copy()  # by the encoder after these steps

    def shift(self, deflection: float, force: float) -> None:
        """Encoder and force sensor read `deflection` [m] and `force` [N] more from now on."""
        shift_geometry(self.geometry, deflection)
        shift_members(self.members, deflection, force)
        self._motion[0][X] += deflection

    def advance(self, steps: Record, deflection: float) -> bool:
        """Do one slice; whether the repetition is complete. `steps`: all stored ones, (n,) STEP.

        `deflection` [m]: one of the data.
        """
        part = steps[self._done : self._done + STEPS_PER_SLICE]
        if self._first and part.size < STEPS_PER_SLICE:
            self._first -= 1
            nest(self.members, self._prior, self.geometry, deflection, self._first)
            return False
        part["relinearizing"] = True
        smooth(steps[self._done : self._done + part.size + self._lag], part.size, *self._motion)
        repeat(self.members[self._first :], self.geometry, part)
        self._done += part.size
        return self._done == steps.size and not self._first


def shift_geometry(geometry: Record, deflection: float) -> None:
    """The encoder reads `deflection` [m] more from now on."""
    geometry["reference"] += deflection
    geometry["origin"] += deflection


def shift_members(members: Record, deflection: float, force: float) -> None:
    """Encoder and force sensor read `deflection` [m] and `force` [N] more from now on."""
    members["mean"][:, X] += deflection
    members["deflection"] += deflection
    members["mean"][:, L] += force
