"""Pairing, timeouts and validity of the joint; instants are given."""

import pytest
from vsa_common.config.configuration import ConfigurationError, build
from vsa_common.types import ResetReason, Status
from vsa_joint.impedance.fusion import JointFusion
from vsa_joint.impedance.pairing import TransmissionEstimate
from vsa_joint.impedance.propagation import ImpedanceEstimate
from vsa_joint.settings import JointConfig
from vsa_joint.tuning import QUEUE_LENGTH

MS = 1_000_000
GOOD = TransmissionEstimate(
    0, 40.0, 1e-4, True, ImpedanceEstimate(2300.0, 4000.0, 0.37, 100.0, 400.0, 1e-4), True, True, True, Status.VALID
)


def fusion(**values):
    return JointFusion(build(JointConfig, values))


def feed(core, side, stamp_ms, now_ms=None, **changes):
    stamp = int(stamp_ms * MS)
    return core.add(side, GOOD._replace(stamp_ns=stamp, **changes), int((stamp_ms if now_ms is None else now_ms) * MS))


def run(core, until, lost=(), offset=0.1, first=0):
    """Both transmissions at 1 kHz, the second `offset` ms later; `lost` has (transmission, index)."""
    out = []
    for k in range(first, until):
        for side, stamp in ((0, k), (1, k + offset)):
            if (side, k) not in lost:
                estimate = feed(core, side, stamp)
                out += [estimate] if estimate else []
    return out


def skews_ms(estimates):
    return [abs(a - b) / MS for a, b in (e.transmission_stamp_ns for e in estimates)]


def test_every_pair_gives_one_estimate_with_the_later_stamp():
    out = run(fusion(), 50)
    assert len(out) == 50
    assert out[7].stamp_ns == out[7].transmission_stamp_ns[1] == 7.1 * MS
    assert all(e.status == Status.VALID and e.stiffness_valid and e.damping_valid and e.inertia_valid for e in out)


@pytest.mark.parametrize("lost", [(0, 20), (1, 20)])
@pytest.mark.parametrize("offset", [0.1, 0.4])
def test_a_lost_sample_costs_one_pair_and_does_not_shift_the_pairing(lost, offset):
    core = fusion(max_skew=0.005)
    out = run(core, 60, lost=[lost], offset=offset)
    assert len(out) == 59
    assert max(skews_ms(out)) == pytest.approx(offset)
    assert core.counts.unpaired == 1


@pytest.mark.parametrize("late", [0.45, 0.55, 0.7])
@pytest.mark.parametrize("side", [0, 1])
def test_a_frame_delayed_by_more_than_half_a_period_pairs_with_its_own_sample(side, late):
    core, out = fusion(max_skew=0.005), []
    for k in range(60):
        stamps = {0: k, 1: k + 0.02}
        stamps[side] += late * (k == 20)
        for number in sorted(stamps, key=stamps.get):
            estimate = feed(core, number, stamps[number])
            out += [estimate] if estimate else []
    assert [round(e.transmission_stamp_ns[1 - side] / MS) for e in out] == list(range(60))
    assert core.counts.unpaired == 0


@pytest.mark.parametrize("side", [0, 1])
def test_frames_delayed_by_a_stall_pair_with_their_own_samples(side):
    """The sender stalled between both frames of a sample, and then caught up."""
    first = [18.0, 19.0, 20.04, 23.01, 23.17, 23.98, 24.15, 25.0, 26.0, 27.0]
    second = [18.02, 19.02, 22.14, 23.03, 23.19, 24.0, 24.17, 25.02, 26.02, 27.02]
    core = fusion()
    out = run(core, 18, offset=0.02)
    arrivals = [(stamp, side) for stamp in first] + [(stamp, 1 - side) for stamp in second]
    out += [estimate for stamp, one in sorted(arrivals) if (estimate := feed(core, one, stamp))]
    expected = [(round(a * MS), round(b * MS)) for a, b in zip(first, second, strict=True)]
    paired = [e.transmission_stamp_ns for e in out[18:]]
    assert [pair if side == 0 else pair[::-1] for pair in paired] == expected[: len(paired)]
    assert len(paired) >= len(expected) - 1  # the last may be pending
    assert core.counts.unpaired == 0


DELAYED = [
    [(1.69, 1.72), (2.64, 2.66), (7.03, 8.17), (8.40, 8.79), (9.03, 9.04), (10.46, 10.48)],
    [(1.01, 1.03), (2.00, 2.02), (2.61, 3.04), (3.19, 3.54), (3.68, 3.70), (4.22, 4.23)],
    [(2.01, 2.03), (2.80, 3.32), (5.14, 7.41), (7.54, 7.55), (8.10, 8.12)],
]


@pytest.mark.parametrize("frames", DELAYED)
@pytest.mark.parametrize("side", [0, 1])
def test_frames_of_a_sender_that_was_interrupted_between_them_pair_with_their_own_samples(frames, side):
    core, out = fusion(max_skew=0.005), []
    run(core, 400, offset=0.02 - 0.04 * side)
    for sample in frames:
        for number, stamp in zip((side, 1 - side), sample, strict=True):
            out.append(feed(core, number, 398.5 + stamp))
    out += run(core, 440, offset=0.02 - 0.04 * side, first=420)
    pairs = [tuple(round(ns / MS - 398.5, 2) for ns in e.transmission_stamp_ns) for e in out if e]
    assert pairs[: len(frames)] == [sample if side == 0 else sample[::-1] for sample in frames]
    assert core.counts.unpaired == 0


@pytest.mark.parametrize("side", [0, 1])
def test_a_long_gap_within_a_sample_does_not_shift_the_pairing(side):
    core, out = fusion(max_skew=0.005), []
    run(core, 400, offset=0.02 - 0.04 * side)
    feed(core, side, 400.0)
    feed(core, 1 - side, 576.7)  # of the same sample
    for k in range(40):
        for number in (side, 1 - side):
            out.append(feed(core, number, 577.0 + 0.1 * k + 0.02 * (number != side)))
    assert skews_ms(filter(None, out)) == pytest.approx([0.02] * 40, rel=1e-3)
    assert core.counts.unpaired == 2


@pytest.mark.parametrize("ahead", [0, 1])
def test_after_a_gap_of_both_transmissions_their_own_samples_pair(ahead):
    core, out = fusion(max_skew=0.005), []
    for k in range(60):
        for side in (0, 1):
            feed(core, side, 20.0 * k + 0.02 * side)
    for side in (0, 1):
        feed(core, side, 1280.0 + 0.02 * side, status=Status.STALE)
    feed(core, 1 - ahead, 1290.0, status=Status.STALE)  # the other transmission has resumed
    for k in range(8):  # the backlog of the gap
        for side in (ahead, 1 - ahead):
            estimate = feed(core, side, 1292.0 + 0.7 * k + 0.02 * (side != ahead))
            out += [estimate] if estimate else []
    assert len(out) == 8
    assert skews_ms(out) == pytest.approx([0.02] * 8, rel=1e-3)
    assert core.counts.unpaired == 0


@pytest.mark.parametrize("silent", [0, 1])
def test_a_prediction_pairs_with_the_simultaneous_measurement_of_the_other_transmission(silent):
    core = fusion(max_skew=0.005)
    run(core, 60)
    out = []
    for k in range(60, 160):
        estimates = [feed(core, 1 - silent, k + 0.3)]
        if k >= 110 and k % 10 == 0:
            estimates.append(feed(core, silent, k + 0.6, status=Status.STALE))
        out += filter(None, estimates)
    assert len(out) == 5
    assert max(skews_ms(out)) < 0.5
    assert all(e.status == Status.STALE for e in out)


def test_stamps_beyond_max_skew_do_not_pair():
    core = fusion(max_skew=0.001)
    assert feed(core, 0, 0) is None
    assert feed(core, 1, 1.5) is None
    assert feed(core, 0, 1.6) is not None
    assert core.counts.unpaired == 1


def test_a_delayed_burst_pairs_in_order():
    core = fusion()
    for k in range(100):
        assert feed(core, 0, k) is None
    out = [feed(core, 1, k + 0.1, now_ms=100) for k in range(100)]
    assert all(out)
    assert max(skews_ms(out)) == pytest.approx(0.1)


def test_the_queue_without_partners_is_bounded():
    core = fusion()
    run(core, QUEUE_LENGTH + 500, lost=[(1, k) for k in range(QUEUE_LENGTH + 500)])
    assert core.counts.unpaired == 500


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


def test_after_a_time_reset_samples_pair():
    core = fusion()
    for side in (0, 1):
        for k in range(20):
            feed(core, side, 5000 + k)
    out = run(core, 30)
    assert len(out) == 30


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
