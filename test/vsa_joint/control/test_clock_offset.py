"""Ages of stamps while the clock that stamps is slewed, stepped, or another computer's."""

import pytest
from vsa_joint.control.clock_offset import StampAge

MS, SECOND = 1_000_000, 1_000_000_000
EPOCH = 1_700_000_000 * SECOND


class Clocks:
    """Ten messages a tenth of a second, each `age` old; the ROS clock may be set, the stamping one may follow."""

    def __init__(self):
        self.age = StampAge()
        self.now = 50 * SECOND
        self.ros = self.stamps = EPOCH  # minus the steady clock

    def ages(self, count, age=5 * MS, slew=0):
        out = []
        for _ in range(count):
            self.now += 10 * MS
            self.ros, self.stamps = self.ros + slew, self.stamps + slew
            instant = self.age.steady(self.now - age + self.stamps, self.now + self.ros, self.now)
            out.append((self.now - instant) / MS)
        return out


def test_a_stamp_is_as_old_as_it_is_and_none_tells_nothing():
    clocks = Clocks()
    assert clocks.ages(10, age=7 * MS) == [7.0] * 10
    assert clocks.ages(10, age=300 * MS) == [300.0] * 10
    assert clocks.age.steady(0, EPOCH, 1) is None


@pytest.mark.parametrize("step", [3600 * SECOND, -3600 * SECOND, SECOND // 5, -SECOND // 5])
@pytest.mark.parametrize("stamps_follow", [True, False])
def test_a_clock_that_is_set_makes_nothing_old_and_a_backlog_is_still_seen(step, stamps_follow):
    clocks = Clocks()
    clocks.ages(10)
    clocks.ros += step
    assert max(map(abs, clocks.ages(1))) <= 5.0  # stamped before
    clocks.stamps += step if stamps_follow else 0
    assert max(map(abs, clocks.ages(50))) <= 5.0
    assert min(clocks.ages(50, age=90 * MS)) >= 80.0


def test_a_clock_that_is_slewed_is_followed():
    clocks = Clocks()
    assert max(clocks.ages(5000, slew=5000)) == 5.0  # 500 ppm
    assert clocks.ages(1, age=90 * MS) == [90.0]
