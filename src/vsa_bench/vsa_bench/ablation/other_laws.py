# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Recordings of transmissions and sensors with other laws, for the bank of laws: cases of `bench mismatch`."""

from collections.abc import Iterator

import numpy as np
from vsa_bench.ablation.recordings import SEED, Recording
from vsa_bench.mismatch.cases import MOTIONS, Case
from vsa_bench.mismatch.metrics import DAMPING_FLOOR
from vsa_bench.mismatch.run import NOMINAL, start_parameters
from vsa_simulator.rig.recording import Simulation

CASES = (
    (Case("spring_quadratic", "mix", 100), 10.0),
    (Case("force_late_5ms", "dwells", 100), 8.0),
    (Case("damper_soft_knee", "fast", 100), 8.0),
    (Case("friction_stribeck", "fast", 100), 8.0),
)


def with_other_laws(seconds: float | None = None) -> Iterator[Recording]:
    """The recordings of CASES with `elastic_law: automatic`, each of its own length or of `seconds` [s]."""
    for one, usual in CASES:
        simulation = Simulation(one.variant, MOTIONS[one.motion], seconds or usual, one.rate_hz)
        measured = simulation.recording(SEED)
        yield Recording(
            one.label, start_parameters(simulation, SEED) | {"elastic_law": "automatic"}, measured.stamp_ns,
            measured.force, measured.deflection, simulation.stiffness, simulation.damping,
            np.asarray(simulation.damping > DAMPING_FLOOR * NOMINAL.d1),
        )  # fmt: skip
