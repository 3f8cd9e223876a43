# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Motion profiles: positions, speeds and frequencies of each."""

import numpy as np
import pytest
from vsa_common.config.configuration import ConfigurationError
from vsa_simulator.rig.motion import ProfileConfig, Tone, chirp, dwells, motion_from, position, ramp, tones
from vsa_simulator.rig.single_transmission import MOTIONS

TIMES = np.arange(0.0, 120.0, 0.01)


def path(motion, times=TIMES):
    return np.array([position(time, motion) for time in times])


def test_hold_is_constant_at_its_centre():
    np.testing.assert_array_equal(path(motion_from(ProfileConfig(kind="hold", centre=0.007))), 0.007)


def test_a_tone_is_its_sine_once_faded_in():
    x = path(tones(0.010, Tone(0.003, 0.2, 0.5), fade_in=8.0))
    late = TIMES >= 8.0
    np.testing.assert_allclose(x[late], 0.010 + 0.003 * np.sin(2 * np.pi * 0.2 * TIMES[late] + 0.5), atol=1e-15)
    assert x[0] == 0.010


def test_a_tone_is_zero_outside_its_start_and_end():
    x = path(tones(0.010, Tone(0.003, 0.2, start=20.0, end=60.0))) - 0.010
    assert not x[(TIMES < 20.0) | (TIMES > 60.0)].any()
    assert np.abs(x).max() == pytest.approx(0.003, rel=1e-3)


def test_every_standard_motion_starts_without_a_step():
    for name, motion in MOTIONS.items():
        steps = np.abs(np.diff(path(motion, np.arange(0.0, 30.0, 0.001))))
        assert steps.max() < 0.007 * 0.001, name  # [m]: no commanded speed exceeds 7 mm/s


@pytest.mark.parametrize(
    ("name", "lowest", "highest"),
    [("slow", 2.5, 17.5), ("slow2", 9.7, 14.3), ("half_hz", 7.95, 10.05), ("dwells", 4, 14), ("one_hz", 11.55, 12.45)],
)
def test_the_standard_motions_cover_their_ranges(name, lowest, highest):
    x = path(MOTIONS[name])
    assert (x.min() * 1e3, x.max() * 1e3) == pytest.approx((lowest, highest), abs=0.01)


def test_dwells_rest_at_their_positions_between_minimum_jerk_moves():
    motion = dwells((0.010, 0.013, 0.007), move=4.0, rest=11.0)
    x = path(motion)
    for number, expected in enumerate([0.013, 0.007, 0.010, 0.013]):
        resting = (15.0 * number + 4.0 <= TIMES) & (15.0 * number + 15.0 > TIMES)
        np.testing.assert_allclose(x[resting], expected, atol=1e-15)
    peak = np.abs(np.diff(x[TIMES < 4.0])).max() / 0.01
    assert peak == pytest.approx(0.003 * 1.875 / 4.0, rel=1e-4)  # minimum jerk: 15/8 of the mean speed


def test_a_chirp_sweeps_between_both_frequencies_and_back():
    motion = chirp(0.0, 1.0, 0.5, 4.5, sweep=20.0, fade_in=0.0)
    times = np.arange(0.0, 80.0, 0.0005)
    crossings = times[1:][np.diff(np.signbit(path(motion, times)))]
    frequency = 0.5 / np.diff(crossings)
    middle = 0.5 * (crossings[1:] + crossings[:-1])
    swept = middle % 40.0
    expected = np.where(swept < 20.0, 0.5 + 0.2 * swept, 4.5 - 0.2 * (swept - 20.0))
    np.testing.assert_allclose(frequency, expected, rtol=0.02)


def test_a_ramp_has_one_speed_in_both_directions():
    x = path(ramp(0.010, 0.004, 0.05, fade_in=0.0))
    speed = np.diff(x) / 0.01
    np.testing.assert_allclose(np.median(np.abs(speed)), 4 * 0.004 * 0.05, rtol=1e-9)
    assert np.mean(np.isclose(np.abs(speed), 4 * 0.004 * 0.05, rtol=1e-6)) > 0.99
    assert (x.min(), x.max()) == pytest.approx((0.006, 0.014), abs=1e-6)


def test_tones_with_unequal_lists_are_refused():
    with pytest.raises(ConfigurationError, match="1, 3 and 3 values"):
        motion_from(ProfileConfig(amplitudes=(0.001,)))
