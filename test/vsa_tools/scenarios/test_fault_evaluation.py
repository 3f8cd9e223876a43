"""Judgement of rehearsed faults, on estimates whose lies are known."""

import numpy as np
import pytest
from vsa_simulator.faults.failure import TYPES, parse
from vsa_tools.scenarios.fault_evaluation import (
    NAMES,
    Estimates,
    Saying,
    judged,
    occasions,
    rig_time,
    undetected_error,
    verdict,
    well_again,
)

SECOND = 1_000_000_000
TIME = np.arange(0.0, 30.0, 0.002)
EVENTS = [(10.0, parse("force stuck -i 1 -t 2")), (20.0, parse("encoder spike -i 2"))]


def estimates(wrong=(0.0, 0.0), invalid=(0.0, 0.0)):
    off = 0.05 * ((wrong[0] <= TIME) & (wrong[1] > TIME))
    valid = ~((invalid[0] <= TIME) & (invalid[1] > TIME))
    return Estimates(TIME, off, off / 0.002, valid, valid)


def test_each_fault_is_judged_until_the_next():
    first, second = occasions(EVENTS)
    assert (first.begin, first.end, first.until) == (10.0, 12.0, 20.0)
    assert (second.begin, second.end) == (20.0, 20.0)


def test_the_longest_lie_counts_and_an_invalid_stiffness_cannot_lie():
    first, _ = occasions(EVENTS)
    assert undetected_error(estimates(wrong=(11.0, 11.3)), first) == (pytest.approx(0.3, abs=0.003), 0.05)
    assert undetected_error(estimates(wrong=(11.0, 11.3), invalid=(10.9, 11.5)), first) == (0.0, 0.0)
    assert undetected_error(estimates(wrong=(25.0, 26.0)), first) == (0.0, 0.0)


def test_well_again_is_measured_from_the_end_and_none_where_it_never_is():
    first, _ = occasions(EVENTS)
    assert well_again(estimates(invalid=(10.5, 13.5)), first) == pytest.approx(1.5, abs=0.003)
    assert well_again(estimates(), first) == 0.0
    assert well_again(estimates(invalid=(10.5, 21.0)), first) is None
    assert well_again(estimates(invalid=(19.99, 21.0)), first) == 0.0  # the next fault, stamped as the last sample


def test_figures_and_verdict_of_a_fault():
    first, second = occasions(EVENTS)
    sayings = [Saying(5 * SECOND, "force sensor stuck"), Saying(int(10.4e9), "transmission_1: force sensor stuck: x")]
    one = judged(first, 10 * SECOND, sayings, {"transmission_1": estimates(invalid=(10.2, 12.5))})
    assert (one["named_after_s"], one["lying_for_s"]) == (0.4, 0.0)
    assert verdict([one]) == {"named": True, "valid_again": True, "never_lying": True}
    other = judged(second, 20 * SECOND, sayings, {"joint": estimates(wrong=(20.1, 20.4))})
    assert verdict([one, other]) == {"named": False, "valid_again": True, "never_lying": False}


def test_every_failure_that_can_be_rehearsed_has_a_name():
    assert set(TYPES) - set(NAMES) == {"ok", "slow"}


def test_the_rigs_clock_is_read_off_the_frames():
    frames, samples = np.array([0, 2, 4]) * SECOND, np.array([0, 200, 400])
    assert rig_time(np.array([SECOND, 3 * SECOND]), frames, samples, 100.0).tolist() == [1.0, 3.0]
