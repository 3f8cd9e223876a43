# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
from vsa_estimator.preprocessing.sensor_flags import ENCODER_FAULT_MASK, EXCLUDE_FROM_UPDATE, SensorFlag


def test_each_flag_is_one_bit_of_its_own():
    assert sorted(flag.value for flag in SensorFlag) == [1 << i for i in range(len(SensorFlag))]


def test_an_encoder_fault_and_the_timing_test_are_not_their_own_cause():
    assert not ENCODER_FAULT_MASK & (SensorFlag.ENCODER_FAULT | SensorFlag.TIMING_SUSPECT)


def test_a_noisy_sensor_is_not_excluded_from_updates():
    assert not EXCLUDE_FROM_UPDATE & (SensorFlag.FORCE_NOISY | SensorFlag.ENCODER_NOISY)
