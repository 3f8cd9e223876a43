# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
import pytest
from vsa_estimator.fault_detection.latch import FAULT_TEXTS, FaultLatch
from vsa_estimator.preprocessing.sensor_flags import SensorFlag
from vsa_estimator.tuning.fault_detection import FAULT_HOLD_TIME

HOLD_NS = int(FAULT_HOLD_TIME * 1e9)
START_NS = 1_000_000_000


@pytest.mark.parametrize("other", [0, SensorFlag.FORCE_STUCK, SensorFlag.BURST | SensorFlag.ENCODER_FAULT])
def test_a_repeated_force_counts_once_whatever_other_flags_are_raised(other):
    latch = FaultLatch()
    for i in range(3):
        latch.add_flags(int(SensorFlag.FORCE_REPEATED | other), START_NS + i)
    latch.add_flags(int(other), START_NS + 3)
    assert latch.force_repeated == 3


@pytest.mark.parametrize("flag", FAULT_TEXTS, ids=lambda flag: flag.name)
def test_a_fault_is_active_for_the_hold_time_after_its_last_detection(flag):
    latch = FaultLatch()
    for stamp_ns in (START_NS, START_NS + 1000):
        latch.add_flags(flag.value, stamp_ns)
    end_ns = START_NS + 1000 + HOLD_NS
    assert latch.active_faults(end_ns - 1) == [FAULT_TEXTS[flag]]
    assert latch.active_faults(end_ns) == []
    assert latch.until_ns == end_ns
    assert latch.sensor_fault_until_ns == (0 if flag is SensorFlag.BURST else end_ns)


def test_clear_ends_all_faults_and_keeps_the_counter():
    latch = FaultLatch()
    latch.add_flags(int(SensorFlag.FORCE_REPEATED | SensorFlag.FORCE_SATURATED), START_NS)
    latch.clear()
    assert latch.active_faults(START_NS) == []
    assert latch.until_ns == 0
    assert latch.force_repeated == 1


def test_faults_that_have_ended_need_no_memory():
    latch = FaultLatch()
    for k in range(1000):
        latch.raise_fault(f"encoder step of {k} mm", START_NS + k * HOLD_NS)
    assert len(latch._until_ns) == 1
