# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Groups of recordings, and which of them exercise the constants of a module."""

from collections.abc import Iterator

from vsa_bench.ablation.disturbances import disturbed
from vsa_bench.ablation.offline import offline_recordings
from vsa_bench.ablation.other_laws import with_other_laws
from vsa_bench.ablation.recordings import recordings
from vsa_bench.ablation.trial import Source

TRACKING, FAULTS, LAWS, OFFLINE = GROUPS = ("tracking", "faults", "laws", "offline")
_LIVE = (TRACKING, FAULTS)
_OWN = {"general": (LAWS,), "offline": (OFFLINE,)}  # modules of constants that the other groups never read


def groups_of(module: str) -> tuple[str, ...]:
    """Groups that exercise the constants of a module, in the order in which they are tried.

    >>> groups_of("vsa_estimator.tuning.preprocessing")
    ('tracking', 'faults')
    >>> groups_of("vsa_estimator.tuning.general")
    ('laws',)
    """
    return _OWN.get(module.rpartition(".")[2], _LIVE)


def sources_of(group: str, quick: bool, seconds: float | None) -> Iterator[Source]:
    """The recordings of a group, each of its own length or of `seconds` [s]; `quick` shortens those of tracking."""
    if group == TRACKING:
        return recordings(quick, seconds)
    return {FAULTS: disturbed, LAWS: with_other_laws, OFFLINE: offline_recordings}[group](seconds)
