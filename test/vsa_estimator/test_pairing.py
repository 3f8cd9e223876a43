"""Force and encoder streams become samples."""

import pytest
from vsa_estimator.pairing import Pairing, Sample

MS = 1_000_000


def test_equal_stamps_make_a_sample_whichever_comes_first():
    pairing = Pairing(0, 50 * MS)
    assert pairing.add_force(10 * MS, 20.0) == []
    assert pairing.add_encoder(10 * MS, 0.01) == [Sample(10 * MS, 20.0, 0.01)]
    assert pairing.add_encoder(20 * MS, 0.02) == []
    assert pairing.add_force(20 * MS, 21.0) == [Sample(20 * MS, 21.0, 0.02)]
    assert pairing.dropped == 0


@pytest.mark.parametrize("lead", [1, 7, 30])
def test_one_side_may_lead_by_many_samples(lead):
    pairing = Pairing(0, 50 * MS)
    out = []
    for k in range(100):
        out += pairing.add_force(k * MS, float(k))
        if k >= lead:
            out += pairing.add_encoder((k - lead) * MS, 0.001 * (k - lead))
    assert [sample.stamp_ns for sample in out] == [k * MS for k in range(100 - lead)]
    assert pairing.dropped == 0


def test_stamps_within_the_tolerance_pair_with_the_nearest_and_take_the_force_stamp():
    pairing = Pairing(2 * MS, 50 * MS)
    pairing.add_force(10 * MS, 1.0)
    pairing.add_force(13 * MS, 2.0)
    assert pairing.add_encoder(12 * MS, 0.01) == []  # the older half still waits
    assert pairing.add_encoder(9 * MS, 0.009) == [Sample(10 * MS, 1.0, 0.009), Sample(13 * MS, 2.0, 0.01)]


def test_a_half_without_partner_is_given_up_and_counted_after_the_window():
    pairing = Pairing(0, 50 * MS)
    pairing.add_force(10 * MS, 1.0)
    pairing.add_force(20 * MS, 2.0)
    assert pairing.add_encoder(20 * MS, 0.02) == []
    pairing.add_force(61 * MS, 3.0)
    assert pairing.dropped == 1
    assert [sample.stamp_ns for sample in pairing.add_encoder(61 * MS, 0.03)] == [61 * MS]


def test_the_pair_behind_a_given_up_half_comes_out_with_it():
    pairing = Pairing(0, 50 * MS)
    pairing.add_force(10 * MS, 1.0)
    pairing.add_force(20 * MS, 2.0)
    pairing.add_encoder(20 * MS, 0.02)
    assert [sample.stamp_ns for sample in pairing.add_force(61 * MS, 3.0)] == [20 * MS]


def test_reordered_halves_come_out_in_order():
    pairing = Pairing(0, 50 * MS)
    out = []
    for k in (0, 2, 1, 3):
        out += pairing.add_force(k * MS, float(k))
    for k in (1, 0, 3, 2):
        out += pairing.add_encoder(k * MS, float(k))
    assert [sample.stamp_ns for sample in out] == [0, MS, 2 * MS, 3 * MS]


def test_queues_are_bounded_when_one_side_is_dead():
    pairing = Pairing(0, 10_000 * MS, capacity=100)
    for k in range(1000):
        pairing.add_force(k * MS, 0.0)
    assert pairing.dropped == 900


def test_a_second_half_with_the_same_stamp_is_counted():
    pairing = Pairing(0, 50 * MS)
    pairing.add_force(10 * MS, 1.0)
    pairing.add_force(10 * MS, 1.5)
    assert pairing.dropped == 1
    assert pairing.add_encoder(10 * MS, 0.01) == [Sample(10 * MS, 1.5, 0.01)]


def test_stamps_that_jump_back_do_not_block_what_follows():
    pairing = Pairing(0, 50 * MS)
    pairing.add_force(100_000 * MS, 1.0)
    pairing.add_force(10 * MS, 2.0)
    assert [sample.stamp_ns for sample in pairing.add_encoder(10 * MS, 0.01)] == [10 * MS]
