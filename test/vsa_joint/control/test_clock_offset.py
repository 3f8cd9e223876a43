# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Ages of stamps under slew and steps of the ROS clock, and of stamps from another host."""

import pytest
from vsa_joint.control.clock_offset import ClockOffset

MS, SECOND = 1_000_000, 1_000_000_000
EPOCH = 1_700_000_000 * SECOND


class Clocks:
    """Messages at 100 Hz; `ros` and `stamps` are the ROS clock and the stamping clock minus the steady clock."""

    def __init__(self):
        self.offset = ClockOffset()
        self.now = 50 * SECOND
        self.ros = self.stamps = EPOCH

    def ages(self, count, age=5 * MS, slew=0):
        out = []
        for _ in range(count):
            self.now += 10 * MS
            self.ros, self.stamps = self.ros + slew, self.stamps + slew
            instant = self.offset.update(self.now - age + self.stamps, self.now + self.ros, self.now)
            out.append((self.now - instant) / MS)
        return out


def test_the_age_of_a_stamp_is_the_time_since_the_measurement_and_zero_has_none():
    clocks = Clocks()
    assert clocks.ages(10, age=7 * MS) == [7.0] * 10
    assert clocks.ages(10, age=300 * MS) == [300.0] * 10
    assert clocks.offset.update(0, EPOCH, 1) is None


@pytest.mark.parametrize("step", [3600 * SECOND, -3600 * SECOND, SECOND // 5, -SECOND // 5])
@pytest.mark.parametrize("stamps_follow", [True, False])
def test_a_step_of_the_clock_does_not_change_ages_and_a_backlog_is_detected(step, stamps_follow):
    clocks = Clocks()
    clocks.ages(10)
    clocks.ros += step
    assert max(map(abs, clocks.ages(1))) <= 5.0  # stamped before the step
    clocks.stamps += step if stamps_follow else 0
    assert max(map(abs, clocks.ages(50))) <= 5.0
    assert min(clocks.ages(50, age=90 * MS)) >= 80.0


def test_the_offset_follows_slew():
    clocks = Clocks()
    assert max(clocks.ages(5000, slew=5000)) == 5.0  # 500 ppm
    assert clocks.ages(1, age=90 * MS) == [90.0]
