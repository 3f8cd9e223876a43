# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Forces that the driver has listed and the recorder has not received."""

import pytest
from vsa_tools.record.missed import SETTLING_NS, MissedForces


@pytest.fixture
def missed():
    """After the first list; stamps from SETTLING_NS + 1 on count."""
    one = MissedForces()
    one.add_listed([0])
    return one


def stamps(*numbers):
    return [SETTLING_NS + number for number in numbers]


def test_forces_of_samples_that_were_listed_a_second_ago_and_not_received_are_missed(missed):
    for stamp_ns in stamps(1, 2, 5):
        missed.add_force(stamp_ns)
    missed.add_listed(stamps(1, 2, 3))
    missed.add_listed(stamps(4, 5))
    assert missed.update() == 0  # they may still be on their way
    missed.add_listed(stamps(5 + SETTLING_NS))
    assert missed.update() == 2


def test_forces_received_after_the_list_do_not_replace_missed_ones(missed):
    missed.add_listed(stamps(1, 2, 3, 3 + SETTLING_NS))
    for stamp_ns in stamps(3, 4, 5, 6):
        missed.add_force(stamp_ns)
    assert missed.update() == 2


def test_samples_until_a_second_after_the_first_list_are_not_missed(missed):
    missed.add_listed(stamps(-2, -1, 0))
    missed.add_listed(stamps(1 + SETTLING_NS))
    assert missed.update() == 0


def test_a_force_that_arrives_late_is_missed_until_then(missed):
    missed.add_listed(stamps(1, 2, 2 + SETTLING_NS))
    assert missed.update() == 2
    missed.add_force(stamps(1)[0])
    missed.add_force(stamps(2)[0])
    assert missed.update() == 0
