# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""D-optimal motion of the family: the greatest determinant of the information on the wanted coefficients.

The criterion is ln det of their covariance after one segment, with the covariance of the present estimate as prior
(D_s-optimality: A. Atkinson, A. Donev, R. Tobias, "Optimum Experimental Designs, with SAS", Oxford 2007, ch. 10; with a
prior: K. Chaloner, I. Verdinelli, "Bayesian experimental design: a review", Statistical Science 10(3), 1995). All
motions of the family last one segment, so that it compares the information per time; multisines for identification are
those of J. Swevers et al., "Optimal robot excitation and identification", IEEE Trans. Robotics and Automation 13(5),
1997. The optimum is local, at the present estimate: the design is repeated for each segment.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from vsa_common.types import Array
from vsa_joint.excitation.balance import Models, Start, balanced_motions
from vsa_joint.excitation.information import information, wanted_covariance
from vsa_joint.excitation.model import COEFFICIENTS
from vsa_joint.excitation.multisine import Multisine, Range, family, paths
from vsa_joint.excitation.tuning import DESIGN_STEP, SEGMENT


@dataclass(frozen=True)
class Task:
    """What the next segment is to find, and from where; immutable, so that another thread can solve it."""

    models: Models
    start: Start
    mean: float  # mean deflection at the begin of the segment, relative to the start [m]
    limits: Range
    quantities: tuple[str, ...]
    sample_rate: float  # of the sensors [Hz]

    def motions(self) -> list[Multisine]:
        """The family within the limits."""
        return list(family(self.limits, min(model.peak_speed for model in self.models)))


@dataclass(frozen=True)
class Design:
    """The chosen motion, and ln det of the wanted covariances of both transmissions after one segment."""

    motion: Multisine
    ln_determinant: float


def choose_motion(task: Task) -> Design:
    """The D-optimal motion. Raises ValueError where the range has no room for one."""
    motions = task.motions()
    if not motions:
        raise ValueError(f"no motion within {1e3 * task.limits.half:.2g} mm to either side")
    criterion = ln_determinants(task, motions)
    best = int(np.argmin(criterion))
    return Design(motions[best], float(criterion[best]))


def ln_determinants(task: Task, motions: Sequence[Multisine]) -> Array:
    """The criterion of each motion, (motions,)."""
    wanted = tuple(COEFFICIENTS.index(name) for name in task.quantities)
    mean = paths(motions, task.mean, DESIGN_STEP, round(SEGMENT / DESIGN_STEP))
    both = balanced_motions(mean, task.mean, DESIGN_STEP, task.start, task.models)
    total = np.zeros(len(motions))
    for model, motion in zip(task.models, both, strict=True):
        gained = information(model, motion, DESIGN_STEP, task.sample_rate)
        total += np.linalg.slogdet(wanted_covariance(_inverse(model.covariance) + gained, wanted))[1]
    return total


def _inverse(covariance: Array) -> Array:
    """Inverse of a covariance, scaled for its condition."""
    scale = np.sqrt(np.diag(covariance))
    outer = np.outer(scale, scale)
    return np.asarray(np.linalg.inv(covariance / outer) / outer)
