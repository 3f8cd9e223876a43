# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""One trial: the estimator imported anew with overridden constants, on all recordings.

Runs in a forked worker in plain Python. Compiled code has its constants built in, and modules compute others from
them at import; only a new import applies an override to both. The bank of laws, which plain Python runs 100 times
slower, is compiled anew for each trial.
"""

import hashlib
import importlib
import os
import sys
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from vsa_bench.ablation.figures import FIELDS, Figures, figures
from vsa_bench.ablation.offline import Identified, Rest, run_identification, run_noise
from vsa_bench.ablation.other_laws import OtherLaw, run_bank
from vsa_bench.ablation.recordings import Recording
from vsa_bench.ablation.samples import Samples, run_preprocessing
from vsa_bench.ablation.variation import Value
from vsa_common.blas import limit_blas_threads
from vsa_common.config.configuration import build
from vsa_common.fork import ForkedTasks
from vsa_common.tuning import CONSTANTS, OVERRIDES

PACKAGE = "vsa_estimator"
STATE_PERIOD_NS = 1_000_000_000  # between two states that go into the digest
SILENCES_NS = (20_000_000, 300_000_000)  # instants after the last sample at which the output is predicted

Source = Recording | Identified | Rest
_sources: list[Source] = []  # of this worker


class TrialError(Exception):
    """The estimator fails with the tuned values."""


@dataclass(frozen=True)
class Trial:
    """Figures and digest of all outputs for each recording; `failure` names the exception that ended the trial."""

    figures: dict[str, Figures]
    digests: dict[str, str]
    failure: str = ""


def initialize_worker(sources: Sequence[Source]) -> None:
    """Give a worker its recordings; what it imports from here on is plain Python, or the bank of laws compiled anew."""
    os.environ["VSA_NO_CACHE" if any(isinstance(one, OtherLaw) for one in sources) else "VSA_NO_NUMBA"] = "1"
    warnings.simplefilter("ignore")
    limit_blas_threads()
    _sources[:] = sources


def import_anew(package: str, overrides: Mapping[tuple[str, str], Value]) -> None:
    """Remove `package` with its declared constants; its next import declares them with `overrides`."""
    for name in list(sys.modules):
        # vsa_common.accel reads VSA_NO_NUMBA and VSA_NO_CACHE at import
        if f"{name}.".startswith((f"{package}.", "vsa_common.accel.")):
            del sys.modules[name]
    for name in list(CONSTANTS):
        if f"{name}.".startswith(f"{package}."):
            del CONSTANTS[name]
    importlib.invalidate_caches()
    OVERRIDES.clear()
    OVERRIDES.update(overrides)


def run_trial(overrides: Mapping[tuple[str, str], Value]) -> Trial:
    """The recordings of this worker with `overrides`, by module and name of the constant.

    In a process of its own: numba does not free the memory of compiled code.
    """
    return ForkedTasks(lambda report: _trial(overrides)).results()[0]


def _trial(overrides: Mapping[tuple[str, str], Value]) -> Trial:
    import_anew(PACKAGE, overrides)
    result: dict[str, Figures] = {}
    digests: dict[str, str] = {}
    try:
        for source in _sources:
            result[source.name], digests[source.name] = _run(source)
    except Exception as error:  # a value that the estimator cannot run with is a finding
        return Trial({}, {}, f"{type(error).__name__}: {error}")
    return Trial(result, digests)


def _run(source: Source) -> tuple[Figures, str]:
    if isinstance(source, Identified):
        return run_identification(source)
    if isinstance(source, OtherLaw):
        return run_bank(source)
    if isinstance(source, Samples):
        return run_preprocessing(source)
    return run_noise(source) if isinstance(source, Rest) else _run_estimator(source)


def _run_estimator(recording: Recording) -> tuple[Figures, str]:
    from vsa_estimator.formulations import create_estimator
    from vsa_estimator.output.estimate import Estimate
    from vsa_estimator.settings import EstimatorConfig

    estimator = create_estimator(build(EstimatorConfig, recording.parameters))
    rows, digest = np.full((len(recording.stamps_ns), len(Estimate._fields)), np.nan), hashlib.sha256()
    samples = zip(recording.stamps_ns.tolist(), recording.force.tolist(), recording.deflection.tolist(), strict=True)
    next_state_ns = 0
    for row, (stamp_ns, force, deflection) in zip(rows, samples, strict=True):
        estimate = estimator.add(stamp_ns, force, deflection)
        if estimate is not None:
            row[:] = estimate
        if stamp_ns >= next_state_ns:
            next_state_ns = stamp_ns + STATE_PERIOD_NS
            digest.update(repr(estimator.state()).encode())
    digest.update(rows.tobytes())
    for silence_ns in SILENCES_NS:
        digest.update(repr(estimator.predict_to(int(recording.stamps_ns[-1]) + silence_ns)).encode())
    estimates = {name: rows[:, Estimate._fields.index(name)] for name in FIELDS}
    return figures(recording, estimates, int(estimator.state().reset_count)), digest.hexdigest()
