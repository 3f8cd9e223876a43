# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Timeouts, status, validity and resets of the joint; instants are given."""

import pytest
from transmission_streams import GOOD, MS, feed, fusion, run
from vsa_common.config.configuration import ConfigurationError
from vsa_common.types import ResetReason, Status


def test_every_pair_gives_one_estimate_with_the_later_stamp():
    out = run(fusion(), 50)
    assert len(out) == 50
    assert out[7].stamp_ns == out[7].transmission_stamp_ns[1] == 7.1 * MS
    assert all(e.status == Status.VALID and e.stiffness_valid and e.damping_valid and e.inertia_valid for e in out)


def test_duplicates_late_and_infinite_samples_are_dropped_and_counted():
    core = fusion()
    run(core, 10)
    before = core.newest
    assert feed(core, 0, 9) is None
    assert feed(core, 1, 3) is None
    assert feed(core, 0, 10, force=float("nan")) is None
    assert feed(core, 0, 11, impedance=GOOD.impedance._replace(damping=float("inf"))) is None
    assert core.counts.dropped == 4
    assert core.newest == before


def test_a_silent_transmission_is_reported_within_a_hundred_milliseconds():
    core = fusion()
    run(core, 20)
    silent_since = None
    for now in range(20, 140, 20):
        feed(core, 0, now)
        estimate = core.check(now * MS)
        if estimate is not None:
            silent_since = silent_since or now
            assert (estimate.status, estimate.stiffness_valid, estimate.force_valid) == (Status.STALE, False, False)
            assert estimate.reason == "transmission_2 silent"
    assert silent_since is not None
    assert silent_since - 19.1 <= 100


def test_a_transmission_that_ends_with_an_unpaired_sample_is_reported_as_silent():
    core = fusion()
    run(core, 20)
    feed(core, 1, 20)
    estimate = None
    for quarter in range(4 * 21, 4 * 200):
        now_ns = quarter * MS // 4
        if quarter % 4 == 0:
            feed(core, 0, quarter // 4)
        estimate = core.check(now_ns)
        if estimate is not None:
            break
    assert estimate.reason == "transmission_2 silent"


def test_a_slow_sensor_is_not_stale_between_its_samples():
    core = fusion()
    for k in range(5):
        feed(core, 0, 100 * k)
        feed(core, 1, 100 * k)
    assert core.check(700 * MS) is None
    assert core.check(1000 * MS) is not None


def test_before_the_first_pair_the_status_is_initializing_with_the_missing_transmission():
    core = fusion()
    assert core.check(0).status == Status.INITIALIZING
    feed(core, 0, 0)
    estimate = core.check(10 * MS)
    assert (estimate.status, estimate.reason) == (Status.INITIALIZING, "no sample yet of transmission_2")


def test_stamps_without_a_pair_are_reported():
    core = fusion(max_skew=0.001)
    for k in range(20):
        feed(core, 0, 10 * k)
        feed(core, 1, 10 * k + 5)
    assert core.check(200 * MS).reason == "no stamps within max_skew of each other"


def test_valid_pairs_end_the_stale_status():
    core = fusion()
    run(core, 20)
    assert core.check(300 * MS).status == Status.STALE
    out = run(core, 420, first=400)
    assert out[-1].status == Status.VALID
    assert out[-1].stiffness_valid


@pytest.mark.parametrize("status", [Status.INITIALIZING, Status.STALE, Status.FAULT])
def test_an_unusable_transmission_invalidates_the_joint_with_its_name_and_status(status):
    core = fusion()
    feed(core, 0, 0)
    estimate = feed(core, 1, 0, status=status)
    assert not estimate.stiffness_valid
    assert not estimate.damping_valid
    assert not estimate.inertia_valid
    assert (estimate.status, estimate.reason) == (status, f"transmission_2 {status.name}")


def test_an_inadequate_model_leaves_the_joint_valid_and_is_named():
    core = fusion()
    feed(core, 0, 0)
    estimate = feed(core, 1, 0, status=Status.MODEL_INADEQUATE)
    assert estimate.stiffness_valid
    assert (estimate.status, estimate.reason) == (Status.MODEL_INADEQUATE, "transmission_2 MODEL_INADEQUATE")


def test_each_quantity_has_its_own_validity():
    core = fusion()
    feed(core, 0, 0, inertia_valid=False)
    estimate = feed(core, 1, 0)
    assert (estimate.stiffness_valid, estimate.damping_valid, estimate.inertia_valid) == (True, True, False)
    feed(core, 0, 1, damping_valid=False, force_valid=False)
    estimate = feed(core, 1, 1)
    assert (estimate.stiffness_valid, estimate.damping_valid, estimate.force_valid) == (True, False, False)


def test_the_reset_counts_add_and_the_reason_is_the_most_recent():
    core = fusion()
    feed(core, 0, 0, reset_count=2, reset_reason=ResetReason.GAP)
    feed(core, 1, 0, reset_count=1, reset_reason=ResetReason.REQUESTED)
    feed(core, 0, 1, reset_count=2, reset_reason=ResetReason.GAP)
    assert feed(core, 1, 1, reset_count=2, reset_reason=ResetReason.INNOVATION).reset_count == 4
    feed(core, 0, 2, reset_count=2, reset_reason=ResetReason.GAP)
    assert feed(core, 1, 2, reset_count=2, reset_reason=ResetReason.INNOVATION).reset_reason == ResetReason.INNOVATION


def test_the_printed_reflection_doubles_the_damping_term():
    values = {"tendon_stiffness": [1e9, 1e9]}
    damping = {}
    for kind in ("consistent", "paper"):
        core = fusion(reflection=kind, **values)
        feed(core, 0, 0)
        damping[kind] = feed(core, 1, 0).damping - 0.01
    assert damping["paper"] == pytest.approx(2.0 * damping["consistent"], rel=1e-5)


def test_a_maxwell_term_above_the_mass_term_is_reported():
    core = fusion()
    feed(core, 0, 0)
    assert feed(core, 1, 0).maxwell_exceeds_mass
    light = GOOD.impedance._replace(damping=100.0)
    feed(core, 0, 1, impedance=light)
    assert not feed(core, 1, 1, impedance=light).maxwell_exceeds_mass


def test_a_geometry_of_three_transmissions_raises():
    with pytest.raises(ConfigurationError, match="radius"):
        fusion(radius=[0.02, 0.02, 0.02])
