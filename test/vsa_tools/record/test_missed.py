# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Forces that the driver has listed and the recorder has not received."""

from vsa_tools.record.missed import MissedForces


def test_forces_listed_before_the_last_update_and_not_received_are_missed():
    missed = MissedForces()
    for stamp_ns in (10, 20, 50):
        missed.add_force(stamp_ns)
    missed.add_listed([10, 20, 30])
    missed.add_listed([40, 50])
    assert missed.update() == 0  # they may still be on their way
    assert missed.update() == 2


def test_samples_from_before_the_first_received_force_are_not_missed():
    missed = MissedForces()
    missed.add_listed([1, 2])
    missed.add_force(30)
    missed.add_listed([10, 20, 30])
    missed.update()
    assert missed.update() == 0


def test_a_force_that_arrives_late_is_not_missed():
    missed = MissedForces()
    missed.add_force(10)
    missed.add_listed([10, 20])
    missed.update()
    missed.add_force(20)
    assert missed.update() == 0
