# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Groups of recordings, and which of them exercise the constants of a module."""

from collections.abc import Callable, Iterator

from vsa_bench.ablation.disturbances import rare_conditions
from vsa_bench.ablation.offline import offline_recordings
from vsa_bench.ablation.other_laws import with_other_laws
from vsa_bench.ablation.recordings import recordings
from vsa_bench.ablation.samples import disturbed_samples
from vsa_bench.ablation.trial import Source

TRACKING, RARE, SAMPLES, LAWS, OFFLINE = GROUPS = ("tracking", "rare", "samples", "laws", "offline")
_ESTIMATOR = (TRACKING, RARE)
_OTHERS = {"preprocessing": (TRACKING, SAMPLES), "general": (LAWS,), "offline": (OFFLINE,)}


def groups_of(module: str) -> tuple[str, ...]:
    """Groups that exercise the constants of a module, in the order in which they are tried.

    >>> groups_of("vsa_estimator.tuning.preprocessing")
    ('tracking', 'samples')
    >>> groups_of("vsa_estimator.tuning.general")
    ('laws',)
    """
    return _OTHERS.get(module.rpartition(".")[2], _ESTIMATOR)


def sources_of(group: str, quick: bool, seconds: float | None) -> Iterator[Source]:
    """The recordings of a group, each of its own length or of `seconds` [s]; `quick` shortens those of tracking."""
    if group == TRACKING:
        return recordings(quick, seconds)
    sources: dict[str, Callable[[float | None], Iterator[Source]]] = {
        RARE: rare_conditions, SAMPLES: disturbed_samples, LAWS: with_other_laws, OFFLINE: offline_recordings
    }  # fmt: skip
    return sources[group](seconds)
