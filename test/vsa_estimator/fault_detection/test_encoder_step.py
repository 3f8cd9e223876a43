# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Isolation of an encoder step among rejected deflections: steps, noise, a stuck encoder, an onset of motion."""

import math

import numpy as np
import pytest
from vsa_estimator.fault_detection.encoder_step import OffsetHypothesis


def rejections(offsets, deflections, residual=0.0, discontinuity=math.nan):
    hypothesis = OffsetHypothesis()
    for offset, deflection in zip(offsets, deflections, strict=True):
        hypothesis.reject(deflection, offset, residual, discontinuity)
    return hypothesis


def moving(count, speed=1e-3):
    return 0.01 + speed * 0.01 * np.arange(count)


def test_a_constant_offset_of_a_moving_encoder_is_confirmed_with_its_size():
    hypothesis = rejections([1e-3] * 8, moving(8))
    assert hypothesis.is_confirmed
    assert hypothesis.size == 1e-3


def test_six_offsets_alike_confirm_a_step():
    assert not rejections([1e-3] * 5, moving(5)).is_confirmed
    assert rejections([1e-3] * 6, moving(6)).is_confirmed


@pytest.mark.parametrize(("scatter", "confirmed"), [(0.2, True), (0.3, False)])
def test_offsets_that_scatter_by_a_quarter_of_the_step_are_not_confirmed(scatter, confirmed):
    offsets = 1e-3 * (1.0 + math.sqrt(1.25) * scatter * np.array([0.0, 1.0, -1.0, 1.0, -1.0, 0.0]))
    assert np.std(offsets[1:]) == pytest.approx(1e-3 * scatter)
    assert rejections(offsets, moving(6)).is_confirmed == confirmed


def test_offsets_of_noise_are_not_confirmed():
    rng = np.random.default_rng(1)
    confirmed = [rejections(1e-3 * rng.standard_normal(8), moving(8)).is_confirmed for _ in range(200)]
    assert np.mean(confirmed) < 0.02


def test_the_growing_offset_of_a_stuck_encoder_is_not_confirmed():
    assert not rejections(-2e-4 * np.arange(1, 9), np.full(8, 0.01)).is_confirmed


def test_growing_offsets_are_an_onset_of_motion():
    assert rejections([1e-4, 2e-4, 4e-4], moving(3)).is_motion_onset
    assert not rejections([1e-3, 1e-3, 1e-3], moving(3)).is_motion_onset


def test_half_of_a_step_is_within_one_change_between_samples():
    assert rejections([1e-3] * 3, moving(3), discontinuity=0.6e-3).is_discontinuous
    assert not rejections([1e-3] * 3, moving(3), discontinuity=0.4e-3).is_discontinuous
    assert not OffsetHypothesis().is_discontinuous


def test_a_motion_outgrows_the_noise_of_one_change():
    """3 mm/s from rest at 100 Hz; encoder noise of 0.01 mm."""
    offsets = [2e-5, 6e-5, 8e-5, 11e-5, 12e-5]
    assert rejections(offsets[:3], moving(3), discontinuity=5e-5).is_discontinuous
    assert not rejections(offsets, moving(5), discontinuity=5e-5).is_discontinuous


def test_an_offset_repeats_the_rejected_ones_from_half_of_their_size_on():
    hypothesis = rejections([1e-3] * 3, moving(3))
    assert hypothesis.is_repeated(0.6e-3)
    assert not hypothesis.is_repeated(0.4e-3)
    assert not OffsetHypothesis().is_repeated(1.0)


def test_the_force_supports_the_expected_position_unless_it_has_changed_by_half_of_the_elastic_force():
    assert rejections([1e-3] * 3, moving(3), residual=0.4).supported_by_force(1.0)
    assert not rejections([1e-3] * 3, moving(3), residual=0.6).supported_by_force(1.0)
    assert rejections([1e-3] * 3, moving(3), residual=math.nan).supported_by_force(1.0)


def test_a_change_of_the_force_against_that_of_a_motion_supports_the_expected_position():
    """As a predicted velocity that is too high gives."""
    assert rejections([1e-3] * 3, moving(3), residual=-0.6).supported_by_force(1.0)
    assert not rejections([-1e-3] * 3, moving(3), residual=-0.6).supported_by_force(-1.0)
