# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Encoding and decoding by a DBC file, against literal frames."""

import cantools
import numpy as np
import pytest
from vsa_driver.can.frames import RIG_DBC, FrameError, FrameSet

OTHER_DBC = """VERSION ""
NS_ :
BS_:
BU_: A
BO_ 100 Motorola: 8 A
 SG_ High : 7|16@0- (0.5,10) [0|0] "N" A
BO_ 101 Muxed: 8 A
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" A
 SG_ First m0 : 8|16@1+ (0.1,0) [0|0] "" A
 SG_ Second m1 : 8|32@1- (1,0) [0|0] "" A
"""


@pytest.fixture
def rig() -> FrameSet:
    return FrameSet(RIG_DBC)


@pytest.fixture
def other(tmp_path) -> FrameSet:
    path = tmp_path / "other.dbc"
    path.write_text(OTHER_DBC)
    return FrameSet(path)


def test_a_force_of_minus_one_newton_is_these_bytes(rig):
    # -1 N = -10000 = 0xFFD8F0, count 0x0102, counter 0xFFFF, all low byte first
    data = bytes.fromhex("f0d8ff0201ffff")
    message = rig.message("Transmission1")
    assert message.id == 0x101
    assert message.encode({"Force": -1.0, "EncoderCount": 0x0102, "RollingCounter": 0xFFFF}) == data
    assert message.decode(data) == {"Force": -1.0, "EncoderCount": 0x0102, "RollingCounter": 0xFFFF}
    assert message.reader("RollingCounter", "Force")(data) == (0xFFFF, -1.0)


def test_identifiers_are_those_of_the_interface_document(rig):
    names = {"Transmission1": 0x101, "Transmission2": 0x102, "Joint": 0x110, "MotorState": 0x120, "MotorCommand": 0x200}
    assert {name: rig.message(name).id for name in names} == names


def test_a_motorola_signal_is_big_endian(other):
    # High: bytes 0 and 1, high byte first, 0xFFFE = -2, times 0.5 plus 10
    assert other.message("Motorola").reader("High")(bytes.fromhex("fffe000000000000")) == (9.0,)


def test_counters_stay_integers(rig):
    count, force = rig.message("Transmission1").reader("EncoderCount", "Force")(bytes(7))
    assert isinstance(count, int)
    assert isinstance(force, float)


def test_a_multiplexed_signal_is_read_from_its_own_page_only(other):
    read = other.message("Muxed").reader("Second")
    assert read(bytes([1, 0xFE, 0xFF, 0xFF, 0xFF, 0, 0, 0])) == (-2,)
    with pytest.raises(FrameError, match="frame without signal 'Second'"):
        read(bytes(8))
    with pytest.raises(FrameError, match="Muxed: "):
        read(bytes([7] * 8))


def test_a_missing_signal_is_named_with_the_nearest_one(rig):
    with pytest.raises(FrameError, match="message Transmission1 has no signal 'Forse'; did you mean Force"):
        rig.message("Transmission1").reader("Forse")


def test_a_missing_message_is_named_with_the_file(rig):
    with pytest.raises(FrameError, match=r"vsa_rig.dbc has no message 'Transmision1'; did you mean Transmission1?"):
        rig.message("Transmision1")


@pytest.mark.parametrize("size", [0, 6, 8, 64])
def test_a_wrong_length_is_refused(rig, size):
    message = rig.message("Transmission1")
    for read in (message.decode, message.reader("Force")):
        with pytest.raises(FrameError, match=f"Transmission1: {size} bytes, expected 7"):
            read(bytes(size))


@pytest.mark.parametrize(
    "values",
    [
        {"Force": 1.0, "EncoderCount": 0},
        {"Force": 900.0, "EncoderCount": 0, "RollingCounter": 0},
        {"Force": float("nan"), "EncoderCount": 0, "RollingCounter": 0},
        {"Force": 1.0, "EncoderCount": 65536, "RollingCounter": 0},
    ],
)
def test_missing_values_and_values_out_of_range_are_refused_by_message_name(rig, values):
    with pytest.raises(FrameError, match="Transmission1"):
        rig.message("Transmission1").encode(values)


def test_a_missing_or_invalid_dbc_is_an_error_of_one_line(tmp_path):
    broken = tmp_path / "broken.dbc"
    broken.write_text("BO_ this is no dbc")
    for path in (tmp_path / "none.dbc", broken):
        with pytest.raises(FrameError, match=f"cannot read DBC {path}") as caught:
            FrameSet(path)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["Transmission1", "Joint", "MotorState", "MotorCommand"])
def test_the_fast_reader_equals_cantools(name):
    message = FrameSet(RIG_DBC).message(name)
    reference = cantools.database.load_file(RIG_DBC).get_message_by_name(name)
    names = [signal.name for signal in reference.signals]
    read = message.reader(*names)
    generator = np.random.default_rng(1)
    for _ in range(200):
        data = generator.bytes(reference.length)
        assert read(data) == tuple(reference.decode(data)[signal] for signal in names)


@pytest.mark.parametrize("name", ["Transmission1", "Joint", "MotorState", "MotorCommand"])
def test_the_fast_encoder_equals_cantools(name):
    message = FrameSet(RIG_DBC).message(name)
    reference = cantools.database.load_file(RIG_DBC).get_message_by_name(name)
    generator = np.random.default_rng(2)
    for _ in range(200):
        values = {}
        for signal in reference.signals:
            low, high = message.signal(signal.name).minimum, message.signal(signal.name).maximum
            value = float(generator.uniform(0.0 if low is None else low, 1.0 if high is None else high))
            values[signal.name] = value if message.signal(signal.name).step < 1.0 else round(value)
        assert message.encode(values) == reference.encode(values)
