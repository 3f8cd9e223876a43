# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Frames of literal bytes to samples; the bytes are packed without the DBC library."""

import struct
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from vsa_driver.acquisition.calibration import TareError, take_tares
from vsa_driver.acquisition.channel import JointSample, Measurement, MotorSample
from vsa_driver.acquisition.commands import CommandFrames
from vsa_driver.acquisition.mapping import load_frames
from vsa_driver.acquisition.router import Router
from vsa_driver.can.bus import Frame
from vsa_driver.settings import DriverSettings, MotorSettings, TransmissionSettings
from vsa_driver.tuning import TARE_SAMPLES

FRAMES = load_frames(DriverSettings().dbc)
NOW = 1_800_000_000_000_000_000
MS = 1_000_000


def transmission(force, count, counter, number=1):
    data = round(force * 1e4).to_bytes(3, "little", signed=True) + struct.pack("<HH", count % 65536, counter % 65536)
    return Frame(arbitration_id=0x100 + number, is_extended_id=False, data=data)


def configured(name, **changes):
    return Router(FRAMES, replace(DriverSettings(), **{name: replace(getattr(DriverSettings(), name), **changes)}))


def counters(router):
    """All counters of a router and of its channels, those of a channel after its name."""
    channels = [*router.transmissions.values(), *router.joint, *([router.motors] if router.motors else [])]
    return router.counts() | {f"{one.name}.{key}": count for one in channels for key, count in one.counts().items()}


def test_a_frame_becomes_a_sample_in_si_with_its_capture_stamp():
    [sample] = Router(FRAMES, DriverSettings()).add(transmission(19.5, 1234, 7), NOW)
    assert sample == Measurement("transmission_1", NOW, 7, pytest.approx(19.5), pytest.approx(0.01234))


def test_a_sample_of_frames_without_a_counter_has_no_sequence_number():
    router = configured("transmission_1", counter_signal="")
    assert [router.add(transmission(19.5, 1234, 0), NOW + k * MS)[0].sequence for k in range(3)] == [None] * 3


def test_calibration_converts_signals_to_newtons_and_metres():
    router = configured(
        "transmission_2", force_scale=2.0, force_offset=-1.0, force_reversed=True,
        encoder_scale=2e-5, encoder_offset=0.001, encoder_reversed=True,
    )  # fmt: skip
    [sample] = router.add(transmission(-10.0, -400, 0, number=2), NOW)
    assert (sample.force, sample.deflection) == (pytest.approx(19.0), pytest.approx(0.009))


@pytest.mark.parametrize("direction", [1, -1])
def test_the_encoder_is_unwrapped_in_both_directions(direction):
    router = configured("transmission_1", encoder_bits=10)
    counts = range(500, 1700, 100) if direction > 0 else range(1600, 400, -100)
    travel = [
        router.add(transmission(20.0, count % 1024, i), NOW + i * MS)[0].deflection for i, count in enumerate(counts)
    ]
    steps = [after - before for before, after in pairwise(travel)]
    assert steps == pytest.approx([direction * 1e-3] * len(steps))


def test_the_encoder_starts_within_the_travel_on_either_side_of_zero():
    router = Router(FRAMES, DriverSettings())
    assert router.add(transmission(20.0, 65531, 0), NOW)[0].deflection == pytest.approx(-5e-5)


def test_a_frame_of_the_wrong_length_is_counted_and_gives_no_sample():
    router = Router(FRAMES, DriverSettings())
    for length in (0, 3, 6, 8):
        assert router.add(Frame(arbitration_id=0x101, is_extended_id=False, data=bytes(length)), NOW) == []
    assert counters(router)["transmission_1.wrong_length"] == 4


def test_unmapped_frames_are_counted_also_one_that_differs_only_in_the_width_of_its_identifier():
    router = Router(FRAMES, DriverSettings())
    assert router.add(Frame(arbitration_id=0x7FF, is_extended_id=False), NOW) == []
    assert router.add(Frame(arbitration_id=0x101, is_extended_id=True, data=bytes(7)), NOW) == []
    assert counters(router)["unmapped_frames"] == 2


def test_the_drivers_own_commands_are_not_unmapped():
    router = Router(FRAMES, DriverSettings())
    assert router.add(Frame(arbitration_id=0x200, is_extended_id=False, data=bytes(8)), NOW) == []
    assert counters(router)["unmapped_frames"] == 0


def test_error_frames_are_counted_and_not_decoded():
    router = Router(FRAMES, DriverSettings())
    assert router.add(Frame(arbitration_id=0x101, is_extended_id=False, is_error_frame=True, data=bytes(7)), NOW) == []
    assert counters(router)["error_frames"] == 1


def test_a_remote_frame_gives_no_sample():
    router = Router(FRAMES, DriverSettings())
    assert router.add(Frame(arbitration_id=0x101, is_extended_id=False, is_remote_frame=True, dlc=7), NOW) == []
    assert counters(router)["transmission_1.wrong_length"] == 1


def test_gaps_and_repeated_frames_are_counted_per_transmission():
    router = Router(FRAMES, DriverSettings())
    for i, counter in enumerate((0, 1, 1, 5)):
        router.add(transmission(20.0, 100, counter), NOW + i * MS)
    counts = counters(router)
    assert [counts[f"transmission_1.{name}"] for name in ("samples", "lost", "duplicates")] == [3, 3, 1]
    assert counts["transmission_2.samples"] == 0


def test_saturation_is_counted_and_the_sample_is_passed_on():
    router = Router(FRAMES, DriverSettings())
    assert len(router.add(transmission(200.0, 2100, 0), NOW)) == 1
    counts = counters(router)
    assert (counts["transmission_1.force_saturated"], counts["transmission_1.deflection_saturated"]) == (1, 1)


def test_a_tare_does_not_average_across_a_silence_of_its_stream():
    router = Router(FRAMES, DriverSettings(silence=0.1))
    for i in range(TARE_SAMPLES // 2):
        router.add(transmission(20.0, 100, i), NOW + i * MS)
    later = NOW + 1000 * MS
    for i in range(TARE_SAMPLES // 2):
        router.add(transmission(20.0, 100, 1000 + i), later + i * MS)
    tare = router.transmissions["transmission_1"].tare
    with pytest.raises(TareError, match=f"{TARE_SAMPLES // 2} of {TARE_SAMPLES}"):
        take_tares([tare])[0]
    for i in range(TARE_SAMPLES // 2, TARE_SAMPLES):
        router.add(transmission(20.0, 100, 1000 + i), later + i * MS)
    assert take_tares([tare])[0] == pytest.approx(20.0)


def test_a_tare_that_is_refused_for_one_transmission_changes_none():
    router = Router(FRAMES, DriverSettings())
    for i in range(TARE_SAMPLES):
        router.add(transmission(20.0, 100, i), NOW + i * MS)
        router.add(transmission(20.0 + i % 2, 100, i, number=2), NOW + i * MS)
    with pytest.raises(TareError, match="not stationary"):
        router.take_tares()
    assert [channel.tare.offset for channel in router.transmissions.values()] == [0.0, 0.0]
    for i in range(TARE_SAMPLES, 2 * TARE_SAMPLES):
        router.add(transmission(30.0, 100, i, number=2), NOW + i * MS)
    assert router.take_tares() == {"transmission_1": pytest.approx(20.0), "transmission_2": pytest.approx(30.0)}


def test_the_tares_are_kept_by_another_router_as_far_as_the_parameters_are_the_same():
    former = Router(FRAMES, DriverSettings())
    for i in range(TARE_SAMPLES):
        for number in (1, 2):
            former.add(transmission(20.0 * number, 100, i, number), NOW + i * MS)
    former.take_tares()
    same = Router(FRAMES, DriverSettings())
    assert same.keep_tares(former) == []
    assert same.add(transmission(21.0, 100, 0), NOW)[0].force == pytest.approx(1.0)
    other = configured("transmission_2", force_scale=2.0)
    assert other.keep_tares(former) == ["transmission_2"]
    assert other.add(transmission(41.0, 100, 0, number=2), NOW)[0].force == pytest.approx(82.0)


def test_joint_and_motor_frames_become_samples():
    router = Router(FRAMES, DriverSettings())
    angle = (-250_000).to_bytes(3, "little", signed=True) + (12_345).to_bytes(3, "little", signed=True) + b"\0\0"
    motor = (100_000).to_bytes(3, "little", signed=True) + (-5).to_bytes(3, "little", signed=True) + b"\x01\x00"
    [joint] = router.add(Frame(arbitration_id=0x110, is_extended_id=False, data=angle), NOW)
    [motors] = router.add(Frame(arbitration_id=0x120, is_extended_id=False, data=motor), NOW + 1)
    assert joint == JointSample(NOW, pytest.approx(-0.25), pytest.approx(0.12345))
    assert motors == MotorSample(NOW + 1, pytest.approx((1.0, -5e-5)), holding=True)


def test_frames_of_a_transmission_that_is_not_connected_are_unmapped():
    router = Router(FRAMES, replace(DriverSettings(), transmissions=("transmission_2",)))
    assert router.add(transmission(20.0, 0, 0, number=1), NOW) == []
    assert len(router.add(transmission(20.0, 0, 0, number=2), NOW)) == 1
    assert router.unmapped_frames == 1


@pytest.fixture
def daq(other_daq):
    return Router(load_frames(other_daq.dbc), other_daq)


def forces(left, right):
    return Frame(arbitration_id=0x18FF017E, is_extended_id=True, data=struct.pack(">hhi", left, right, 0))


def positions(left, right):
    return Frame(arbitration_id=32, is_extended_id=False, data=struct.pack("<ii", left, right))


def test_force_and_encoder_of_two_messages_make_one_sample_with_the_stamp_of_the_first(daq):
    assert daq.add(forces(1950, -300), NOW) == []
    one, two = daq.add(positions(9000, -50), NOW + MS)
    assert one == Measurement("transmission_1", NOW, None, pytest.approx(19.5), pytest.approx(0.009))
    assert two == Measurement("transmission_2", NOW, None, pytest.approx(-3.0), pytest.approx(-5e-5))


def test_a_sample_of_which_a_message_is_missing_is_counted_and_not_merged_with_the_next(daq):
    daq.add(forces(1000, 0), NOW)
    daq.add(forces(2000, 0), NOW + MS)
    one, _ = daq.add(positions(9000, 0), NOW + 2 * MS)
    assert (one.force, one.stamp_ns) == (pytest.approx(20.0), NOW + MS)
    assert counters(daq)["transmission_1.incomplete"] == 1


def two_messages(samples=40, lost=(), swapped=(), step_ns=0):
    """Frames every 10 ms, the second 1 ms after the first, both with the number of their sample; and their stamps.

    `lost` has pairs (sample, frame), `swapped` samples whose frames arrive in the opposite order. The clock is set
    by `step_ns` between both frames of sample 20.
    """
    arrivals = []
    for k in range(samples):
        frames = [(0, forces(100 * k, 0)), (1, positions(100 * k, 0))]
        for order, (which, frame) in enumerate(reversed(frames) if k in swapped else frames):
            if (k, which) not in lost:
                shift = step_ns if (k, order) >= (20, 1) else 0
                arrivals.append((frame, NOW + k * 10 * MS + order * MS + shift))
    return arrivals


def merged_samples(daq, arrivals):
    """Numbers of the samples that each measurement of transmission_1 is made of: by force, by deflection."""
    found = [sample for frame, stamp_ns in arrivals for sample in daq.add(frame, stamp_ns)]
    pairs = [(one.force, one.deflection) for one in found if one.transmission == "transmission_1"]
    return [round(force) for force, _ in pairs], [round(deflection * 1e4) for _, deflection in pairs]


@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize("swapped", [(), (7, 30)])
def test_after_the_loss_of_either_message_force_and_encoder_are_of_one_sample_again(daq, which, swapped):
    by_force, by_deflection = merged_samples(daq, two_messages(lost=[(20, which)], swapped=swapped))
    assert by_force == by_deflection == [k for k in range(40) if k != 20]
    assert counters(daq)["transmission_1.incomplete"] == 1


def test_messages_that_arrive_in_the_opposite_order_make_one_sample(daq):
    by_force, by_deflection = merged_samples(daq, two_messages(swapped=(12, 20, 21)))
    assert by_force == by_deflection == list(range(40))
    assert counters(daq)["transmission_1.incomplete"] == 0


@pytest.mark.parametrize("step_ns", [-3_600_000 * MS, -4 * MS, 100 * MS, 3_600_000 * MS])
def test_a_clock_that_is_set_between_two_messages_costs_that_sample_only(daq, step_ns):
    by_force, by_deflection = merged_samples(daq, two_messages(step_ns=step_ns))
    assert by_force == by_deflection == [k for k in range(40) if k != 20]


def test_messages_of_a_slower_device_make_samples_again_after_a_change_of_its_rate(daq):
    fast = two_messages(samples=200)
    slow = [(forces(100, 0), 0), (positions(100, 0), 20 * MS)]
    later = [(frame, NOW + 10_000 * MS + k * 50 * MS + delay) for k in range(300) for frame, delay in slow]
    by_force, by_deflection = merged_samples(daq, fast + later)
    assert by_force == by_deflection
    assert len(by_force) > 200 + 150


def test_a_value_out_of_range_of_the_dbc_is_counted_and_dropped(daq):
    daq.add(forces(30_001, 0), NOW)
    assert [sample.transmission for sample in daq.add(positions(0, 0), NOW)] == ["transmission_2"]
    assert counters(daq)["transmission_1.out_of_range"] == 1


def test_commands_are_numbered_and_encoded_by_the_dbc():
    commands = CommandFrames(FRAMES, MotorSettings(scale=2.0))
    first = commands.encode((1.0, -0.5))
    number = int.from_bytes(first[6:], "little")
    assert first[:6] == (50_000).to_bytes(3, "little", signed=True) + (-25_000).to_bytes(3, "little", signed=True)
    assert int.from_bytes(commands.encode((0.0, 0.0))[6:], "little") == number + 1


@settings(max_examples=300, deadline=None)
@given(
    st.lists(
        st.tuples(st.sampled_from((0x101, 0x102, 0x110, 0x120, 5)), st.booleans(), st.binary(max_size=8)),
        max_size=30,
    )
)
def test_no_frame_raises_and_every_sample_is_finite(frames):
    router = Router(FRAMES, DriverSettings())
    for i, (identifier, extended, data) in enumerate(frames):
        for sample in router.add(Frame(arbitration_id=identifier, is_extended_id=extended, data=data), NOW + i):
            if isinstance(sample, Measurement):
                assert abs(sample.force) < 1e3
                assert abs(sample.deflection) < 1e6
    counts = counters(router)
    taken = sum(
        count
        for name, count in counts.items()
        if name.rsplit(".")[-1] in ("samples", "wrong_length", "unmapped_frames", "duplicates", "late", "implausible")
    )
    assert taken == len(frames)


def test_default_transmission_settings_are_those_of_transmission_1():
    assert TransmissionSettings() == DriverSettings().transmission("transmission_1")
    assert DriverSettings().transmission("transmission_2").force_signal == "Transmission2.Force"
