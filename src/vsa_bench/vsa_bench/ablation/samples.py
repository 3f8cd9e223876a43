# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Disturbed recordings for the preprocessing alone: instants of the samples and flags of the sensors."""

import hashlib
from collections.abc import Iterator
from dataclasses import fields

import numpy as np
from vsa_bench.ablation.disturbances import DISTURBANCES, SECONDS, disturbed
from vsa_bench.ablation.figures import SCORED_FROM, Figures
from vsa_bench.ablation.recordings import Recording
from vsa_common.config.configuration import build


class Samples(Recording):
    """A recording for the preprocessing."""


def disturbed_samples(seconds: float | None = None) -> Iterator[Samples]:
    """One recording for each of DISTURBANCES, of `seconds` [s]."""
    for name in DISTURBANCES:
        one = disturbed(name, seconds or SECONDS)
        yield Samples(*(getattr(one, field.name) for field in fields(Recording)))


def run_preprocessing(recording: Samples) -> tuple[Figures, str]:
    """Figures and digest of the preprocessing: instants, flags and blocks of all samples."""
    from vsa_estimator.preprocessing.pipeline import Pipeline, preprocess
    from vsa_estimator.preprocessing.validation import ACCEPT, TIME_RESET
    from vsa_estimator.settings import EstimatorConfig

    pipeline, digest, resets = Pipeline(build(EstimatorConfig, recording.parameters)), hashlib.sha256(), 0
    samples = zip(recording.stamps_ns.tolist(), recording.force.tolist(), recording.deflection.tolist(), strict=True)
    error_ns, flagged = np.full(len(recording.force), np.nan), np.zeros(len(recording.force), np.bool_)
    for i, sample in enumerate(samples):
        pipeline.set_beyond_peak_speed(not recording.damping_defined[i])
        outcome, flags, instant_ns, finished = preprocess(pipeline.state, *sample)
        if outcome == TIME_RESET:
            resets += 1
            pipeline.reset()
            outcome, flags, instant_ns, finished = preprocess(pipeline.state, *sample)
        blocks = pipeline.finished(finished)
        digest.update(repr((outcome, flags, instant_ns, blocks)).encode())
        flagged[i] = flags > 0
        if outcome == ACCEPT:
            error_ns[i] = instant_ns - recording.instants_ns[i]
    scored = np.isfinite(error_ns) & (np.arange(len(error_ns)) >= SCORED_FROM * len(error_ns))
    return Figures(
        instant_error=float(np.sqrt(np.mean(error_ns[scored] ** 2))), flagged=float(np.mean(flagged)),
        accepted=float(np.mean(np.isfinite(error_ns))), resets=resets,
    ), digest.hexdigest()  # fmt: skip
