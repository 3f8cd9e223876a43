# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Recordings of transmissions and sensors with other laws (cases of `bench mismatch`), and runs of the bank of laws.

The bank runs without the filter beside it: what it costs to compile is a fifth of the whole.
"""

import hashlib
import math
from collections.abc import Iterator

import numpy as np
from vsa_bench.ablation.figures import FIELDS, Figures, figures
from vsa_bench.ablation.recordings import SEED, Recording
from vsa_bench.mismatch.cases import MOTIONS, Case
from vsa_bench.mismatch.metrics import DAMPING_FLOOR
from vsa_bench.mismatch.run import NOMINAL, start_parameters
from vsa_common.config.configuration import build
from vsa_simulator.rig.recording import Simulation

CASES = (
    (Case("spring_quadratic", "mix", 100), 30.0),
    (Case("force_late_5ms", "dwells", 100), 25.0),
    (Case("damper_soft_knee", "fast", 100), 25.0),
    (Case("friction_stribeck", "mix", 100), 25.0),
)
GAP, GAP_NS = 0.8, 300_000_000  # a silence in each recording: at this share of it [ns]


class OtherLaw(Recording):
    """A recording for the bank of laws."""


def with_other_laws(seconds: float | None = None) -> Iterator[OtherLaw]:
    """The recordings of CASES, each of its own length or of `seconds` [s]."""
    for one, usual in CASES:
        simulation = Simulation(one.variant, MOTIONS[one.motion], seconds or usual, one.rate_hz)
        measured = simulation.recording(SEED)
        recording = OtherLaw(
            one.label, start_parameters(simulation, SEED), measured.stamp_ns, measured.force, measured.deflection,
            simulation.stiffness, simulation.damping,
            damping_defined=np.asarray(simulation.damping > DAMPING_FLOOR * NOMINAL.d1), instants_ns=measured.stamp_ns,
        )  # fmt: skip
        late_ns = measured.stamp_ns - measured.stamp_ns[0] - round(GAP * 1e9 * simulation.time[-1])
        yield recording.selected(np.asarray((late_ns < 0) | (late_ns > GAP_NS)))


def run_bank(recording: OtherLaw) -> tuple[Figures, str]:
    """Figures and digest of the bank; its stiffness and damping count as valid where it is comparable to the filter."""
    from vsa_estimator.law_selection import LawSelection
    from vsa_estimator.settings import EstimatorConfig

    config = build(EstimatorConfig, recording.parameters)
    laws, period_ns = LawSelection(config.initial, config.filter_rate), 1e9 / config.filter_rate
    variances = config.deflection_std**2, config.force_noise_std**2
    rows, digest, last_ns = np.empty((len(recording.force), len(FIELDS))), hashlib.sha256(), 0
    samples = zip(recording.stamps_ns.tolist(), recording.force.tolist(), recording.deflection.tolist(), strict=True)
    for row, (stamp_ns, force, deflection) in zip(rows, samples, strict=True):
        if last_ns and stamp_ns - last_ns > 2.0 * period_ns:
            laws.interrupt()
        last_ns = stamp_ns
        laws.step(stamp_ns, (deflection, variances[0]), (force, variances[1]))
        laws.bank.repeat_slice()
        now, comparable = laws.impedance[0], laws.is_comparable
        stiffness = math.exp(now["ln_stiffness"])
        row[:] = (
            stiffness, stiffness**2 * now["ln_stiffness_variance"], comparable,
            now["damping"], now["damping_variance"], comparable,
        )  # fmt: skip
        digest.update(laws.impedance.tobytes() + bytes((comparable, laws.is_refuted, laws.has_failed)))
    digest.update(repr(laws.bank.elastic_law()).encode())
    return figures(recording, dict(zip(FIELDS, rows.T, strict=True)), 0), digest.hexdigest()
