# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Block averages of fast samples."""

import numpy as np
import pytest
from vsa_estimator.preprocessing.decimator import (
    Decimated,
    add_sample,
    finished_blocks,
    initial_decimator,
    is_decimating,
)

MS = 1_000_000


def blocks_of(stamps, deflections, forces, rate=100.0, usable=None):
    decimator, blocks = initial_decimator(rate)[0], []
    for k, sample in enumerate(zip(stamps, deflections, forces, strict=True)):
        usable_now = usable is None or bool(usable[k])
        blocks += finished_blocks(decimator, add_sample(decimator, *sample, True, usable_now))
    return blocks, decimator


def test_samples_at_the_filter_s_rate_pass_unchanged():
    stamps = [10 * MS * k for k in range(1, 20)]
    blocks, decimator = blocks_of(stamps, [0.01] * 19, [30.0] * 19)
    assert blocks[1:] == [Decimated(stamp, 0.01, 30.0, 1, 1, 0.0, 0.0) for stamp in stamps[2:]]
    assert not is_decimating(decimator["period_ns"], decimator["span_ns"])


def test_fast_samples_are_averaged_over_a_period_of_the_filter():
    k = np.arange(1, 101)
    blocks, decimator = blocks_of((k * MS).tolist(), (1e-4 * k).tolist(), (30.0 + k).tolist())
    assert is_decimating(decimator["period_ns"], decimator["span_ns"])
    assert decimator["period_ns"] == MS
    for block in blocks[1:]:
        assert block.samples == block.forces == 10
        assert block.deflection == pytest.approx(1e-4 * block.stamp_ns / MS, abs=1e-4)
        assert block.force == pytest.approx(30.0 + 1e4 * block.deflection, abs=1e-9)


def test_a_block_has_the_greatest_and_the_least_change_between_its_samples_and_from_the_block_before():
    k = np.arange(1, 101)
    deflections = 1e-5 * k + np.where(k > 50, 3e-4, 0.0)
    blocks, _ = blocks_of((k * MS).tolist(), deflections.tolist(), [30.0] * 100)
    steps = [block for block in blocks[1:] if block.max_increment > 2e-5]
    assert [(block.max_increment, block.min_increment) for block in steps] == [pytest.approx((3.1e-4, 1e-5))]
    rest = [block for block in blocks[1:] if block not in steps]
    assert all((block.max_increment, block.min_increment) == pytest.approx((1e-5, 1e-5)) for block in rest)


def test_unusable_forces_do_not_enter_the_mean():
    k = np.arange(1, 101)
    blocks, _ = blocks_of((k * MS).tolist(), [0.01] * 100, np.where(k % 2, 30.0, 99.0).tolist(), usable=k % 2)
    assert all(block.force == 30.0 and block.forces == 5 for block in blocks[1:])


def test_force_and_deflection_of_a_block_are_means_of_the_same_samples():
    k = np.arange(1, 401)
    usable = np.random.default_rng(3).random(k.size) < 0.4
    blocks, _ = blocks_of((k * MS).tolist(), (1e-4 * k).tolist(), (30.0 + k).tolist(), usable=usable)
    assert {block.samples for block in blocks[1:]} > {2, 3, 4, 5}
    for block in blocks:
        assert block.forces in (0, block.samples)
        assert block.deflection == pytest.approx(1e-4 * block.stamp_ns / MS, abs=1e-9)
        assert not block.forces or block.force == pytest.approx(30.0 + 1e4 * block.deflection, abs=1e-9)


def test_a_block_without_a_usable_force_has_all_deflections():
    k = np.arange(1, 101)
    blocks, _ = blocks_of((k * MS).tolist(), (1e-4 * k).tolist(), [30.0] * 100, usable=np.zeros(100))
    assert all(block.samples == 10 and block.forces == 0 for block in blocks[1:])


def test_no_block_spans_a_gap():
    stamps = [MS * k for k in (*range(1, 35), *range(100, 135))]
    blocks, _ = blocks_of(stamps, [0.01] * len(stamps), [30.0] * len(stamps))
    assert not any(40 * MS < block.stamp_ns < 100 * MS for block in blocks)
    assert sum(block.samples for block in blocks) >= len(stamps) - 10
