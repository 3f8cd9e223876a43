# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Failures: syntax, and the effect of each on readings and frames."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from ament_index_python.packages import get_package_share_directory
from vsa_simulator.faults.failure import INSTANCES, TYPES, Event, Failure, FailureError, parse, scenario
from vsa_simulator.faults.injection import Faults, TxFrame
from vsa_simulator.rig.config import SensorConfig

RATE = 100


def faults(*words, at=0):
    injected = Faults(RATE, SensorConfig(), 0)
    for text in words:
        injected.inject(parse(text), at)
    return injected


def readings(injected, component, values, instance=1):
    out = []
    for sample, value in enumerate(values):
        injected.expire(sample)
        out.append(injected.reading(component, instance, float(value), sample))
    return out


def sent(injected, samples, instance=1):
    """(sample at which it was sent, first data byte) of each frame; the data byte is the sample of its origin."""
    out = []
    for sample in range(samples):
        injected.expire(sample)
        out += [(sample, f.data[0]) for f in injected.frames(instance, TxFrame(0x101, bytes([sample])), sample)]
    return out


def test_the_syntax_of_px4_is_parsed():
    assert parse("failure force stuck -i 1 -t 5") == Failure("force", "stuck", 1, 5.0)
    for kind in ("ok", "off", "stuck", "garbage", "slow", "delayed", "intermittent"):
        for component in INSTANCES:
            assert parse(f"{component} {kind}").kind == kind
    assert parse("force wrong").kind == "wrong"


def test_the_text_of_a_failure_parses_to_itself():
    for text in ("force stuck -i 1 -t 5", "encoder drift -v 0.0002", "can_signal bus_off -t 0.5", "torque ok"):
        assert parse(str(parse(text))) == parse(text)


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ("", "expected <component> <failure type>"),
        ("force", "expected <component> <failure type>"),
        ("gyro off", "no component 'gyro'"),
        ("force broken", "no failure type 'broken'"),
        ("force duplicate", "unsupported, force cannot be duplicate"),
        ("can_signal drift", "unsupported, can_signal cannot be drift"),
        ("angle wrap", "unsupported, angle cannot be wrap"),
        ("force off -i 3", "instance 3: there are 2 of force"),
        ("force off -i 0.5", "instance 0.5"),
        ("force off -t -1", "-t -1: expected"),
        ("force off -v nan", "-v nan: expected"),
        ("force off -x 1", "-x 1: expected"),
        ("force slow -v 0", "-v 0 is too small"),
        ("force 'off", "No closing quotation"),
    ],
)
def test_invalid_failures_are_refused_with_the_reason(words, reason):
    with pytest.raises(FailureError) as caught:
        parse(words)
    assert reason in str(caught.value)


def test_a_scenario_is_a_list_of_events_by_time():
    events = scenario([{"at": 5, "failure": "force off"}, {"at": 2.5, "push": -0.1}])
    assert events == (Event(2.5, push=-0.1), Event(5.0, Failure("force", "off")))


@pytest.mark.parametrize(
    ("entries", "reason"),
    [
        ("force off", "expected a list"),
        (None, "expected a list"),
        ([{"at": 1.0}], "entry 1: expected"),
        ([{"at": 1.0, "push": 0.1}, {"at": "soon", "failure": "force off"}], "entry 2: at = 'soon'"),
        ([{"at": float("nan"), "push": 0.1}], "entry 1: at = nan"),
        ([{"at": 1.0, "failure": "force of"}], "entry 1: 'force of': no failure type 'of'"),
    ],
)
def test_an_invalid_scenario_is_refused_with_the_entry(entries, reason):
    with pytest.raises(FailureError) as caught:
        scenario(entries)
    assert reason in str(caught.value)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("force off", [0, 0, 0, 0, 0, 0]),
        ("force stuck", [1, 1, 1, 1, 1, 1]),
        ("force wrong -v 0.5", [1.5, 2.5, 3.5, 4.5, 5.5, 6.5]),
        ("force slow -v 3", [1, 1, 1, 4, 4, 4]),
        ("force delayed -v 0.02", [1, 1, 1, 2, 3, 4]),
        ("force spike -v 9", [10, 2, 3, 4, 5, 6]),
        ("force drift -v 50", [1, 2.5, 4, 5.5, 7, 8.5]),
        ("force saturated", [200] * 6),
        ("force stuck -t 0.03", [1, 1, 1, 4, 5, 6]),
        ("force stuck -i 2", [1, 2, 3, 4, 5, 6]),
    ],
)
def test_readings_of_a_faulty_force_sensor(words, expected):
    injected = faults(words)
    assert readings(injected, "force", [1, 2, 3, 4, 5, 6]) == expected
    assert readings(injected, "angle", [1, 2]) == [1, 2]


def test_garbage_fills_the_range_of_the_sensor():
    values = np.array(readings(faults("force garbage"), "force", np.full(2000, 30.0)))
    assert -200.0 <= values.min() < -190.0
    assert 190.0 < values.max() <= 200.0
    counts = np.array(readings(faults("encoder garbage"), "encoder", np.full(2000, 1000.0)))
    assert (counts >= 0).all()
    assert (counts <= 65535).all()
    assert np.ptp(counts) > 60000


def test_a_noise_failure_multiplies_the_standard_deviation():
    quiet = 30.0 + 0.017 * np.random.default_rng(1).standard_normal(4000)
    assert np.std(readings(faults("force noise -v 10"), "force", quiet)) == pytest.approx(0.17, rel=0.03)


def test_an_intermittent_sensor_drops_its_fraction_of_readings():
    values = np.array(readings(faults("force intermittent -v 0.2"), "force", np.full(5000, 30.0)))
    assert np.mean(values == 0.0) == pytest.approx(0.2, abs=0.02)
    assert set(values) == {0.0, 30.0}


def test_encoder_faults_are_in_counts_and_wrap():
    assert readings(faults("encoder wrong -v 0.002"), "encoder", [1000, 65500]) == [1200, 164]
    assert readings(faults("encoder spike"), "encoder", [1000, 1001]) == [1100, 1001]
    assert readings(faults("encoder saturated"), "encoder", [1000]) == [2000]


def test_a_wrapping_encoder_continues_through_zero():
    assert readings(faults("encoder wrap"), "encoder", [1000, 1001, 1003, 999]) == [65535, 0, 2, 65534]


def test_each_instance_holds_its_own_value():
    injected = faults("force stuck")
    assert [injected.reading("force", instance, value, 0) for instance, value in ((1, 5.0), (2, 7.0))] == [5.0, 7.0]
    assert [injected.reading("force", instance, 9.0, 1) for instance in (1, 2)] == [5.0, 7.0]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("can_signal off -t 0.03", [(3, 3), (4, 4), (5, 5)]),
        ("can_signal stuck -t 0.02", [(0, 0), (1, 0), (2, 2), (3, 3), (4, 4), (5, 5)]),
        ("can_signal slow -v 2", [(0, 0), (2, 2), (4, 4)]),
        ("can_signal duplicate -t 0.02", [(0, 0), (0, 0), (1, 1), (1, 1), (2, 2), (3, 3), (4, 4), (5, 5)]),
        ("can_signal delayed -v 0.02", [(2, 0), (3, 1), (4, 2), (5, 3)]),
        ("can_signal delayed -v 0.02 -t 0.03", [(2, 0), (3, 1), (3, 2), (3, 3), (4, 4), (5, 5)]),
        ("can_signal reordered", [(1, 1), (1, 0), (3, 3), (3, 2), (5, 5), (5, 4)]),
        ("can_signal off -i 2", [(n, n) for n in range(6)]),
    ],
)
def test_frames_of_a_faulty_bus(words, expected):
    assert sent(faults(words), 6) == expected


def test_intermittent_frames_are_lost_by_their_fraction():
    injected = faults("can_signal intermittent -v 0.3")
    count = sum(len(injected.frames(1, TxFrame(0x101, b"\0"), n)) for n in range(5000))
    assert count / 5000 == pytest.approx(0.7, abs=0.02)


def test_garbage_frames_have_any_length_under_the_same_identifier():
    injected = faults("can_signal garbage")
    frames = [injected.frames(1, TxFrame(0x101, bytes(7)), n)[0] for n in range(300)]
    assert {frame.arbitration_id for frame in frames} == {0x101}
    assert {len(frame.data) for frame in frames} == set(range(9))


def test_bus_off_is_one_error_frame_and_then_no_frame_of_any_kind():
    injected = faults("can_signal bus_off -t 0.03")
    frames = []
    for sample in range(5):
        injected.expire(sample)
        for instance in (1, 2, 0):
            frames += [(sample, frame.error) for frame in injected.frames(instance, TxFrame(1, b""), sample)]
    assert frames == [(0, True)] + [(sample, False) for sample in (3, 3, 3, 4, 4, 4)]


def test_ok_ends_what_it_names_and_nothing_else():
    injected = faults("force stuck -i 1", "force stuck -i 2", "encoder stuck")
    injected.inject(parse("force ok -i 1"), 3)
    assert injected.active == (Failure("force", "stuck", 2), Failure("encoder", "stuck"))
    injected.inject(parse("encoder ok"), 4)
    assert injected.active == (Failure("force", "stuck", 2),)


def test_failures_add_up():
    assert readings(faults("force wrong -v 1", "force stuck"), "force", [5, 6, 7]) == [6, 6, 6]


def test_the_same_seed_gives_the_same_failure():
    one, two = (readings(faults("force garbage"), "force", range(50)) for _ in range(2))
    assert one == two


def test_every_type_works_on_every_component_that_supports_it():
    supported = 0
    for component in INSTANCES:
        for kind in TYPES:
            try:
                injected = faults(f"{component} {kind}")
            except FailureError:
                continue
            supported += 1
            if component == "can_signal":
                injected.frames(1, TxFrame(1, bytes(7)), 0)
            else:
                assert np.isfinite(injected.reading(component, 1, 12.0, 0))
    assert supported == 4 * 12 + 1 + 10


def test_the_packaged_scenario_is_valid_and_has_every_fault_class():
    path = Path(get_package_share_directory("vsa_simulator"), "config", "scenario_faults.yaml")
    kinds = {event.failure.kind for event in scenario(yaml.safe_load(path.read_text()))}
    assert kinds >= {
        "stuck", "intermittent", "spike", "drift", "noise", "delayed", "duplicate", "bus_off", "wrap", "saturated",
    }  # fmt: skip
