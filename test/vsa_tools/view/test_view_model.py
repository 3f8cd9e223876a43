# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""View model of the live page: bins, state, events and reasons against literal values."""

import json
import math

import pytest
from rclpy.serialization import serialize_message
from view_messages import JOINT, SIDE, STATE, S, counters, diagnostic, filled_model, impedance
from vsa_common.stamps import set_stamp
from vsa_msgs.msg import EstimatorState
from vsa_tools.view.events import CounterWatch, Events, StatusTracker
from vsa_tools.view.no_data import no_data_reasons
from vsa_tools.view.time_series import (
    BIN_NS,
    HOLD_BINS,
    MAX_BINS,
    MAX_LAG,
    Delays,
    Stream,
    TimeSeriesStore,
    count_lost,
    quantity,
    status_label,
)
from vsa_tools.view.view_model import ViewModel


def test_a_spike_of_one_sample_in_a_thousand_remains_visible():
    stream = Stream(("force",))
    for k in range(1000):
        stream.add(k * 1_000_000, (500.0 if k == 617 else 1.0,))
    rows = TimeSeriesStore({"side": stream}).frame(0)
    assert max(value for value in rows["high"][0]) == 500.0
    assert rows["low"][0][617 // 20] == 1.0
    assert len(rows["low"][0]) == rows["end"] == 1000 * 1_000_000 // BIN_NS - 1 - MAX_LAG


def test_a_slow_topic_is_held_for_a_quarter_second_and_then_missing():
    fast, slow = Stream(("a",)), Stream(("b",))
    slow.add(0, (7.0,))
    for index in range(60):
        fast.add(index * BIN_NS, (1.0,))
    low = TimeSeriesStore({"fast": fast, "slow": slow}).frame(0)["low"][1]
    assert low[:HOLD_BINS] == [7.0] * HOLD_BINS
    assert low[HOLD_BINS:] == [None] * (len(low) - HOLD_BINS)


def test_frames_continue_where_the_last_one_ended():
    stream, begin, received = Stream(("a",)), 0, []
    store = TimeSeriesStore({"side": stream})
    for index in range(200):
        stream.add(index * BIN_NS, (float(index),))
        if index % 7 == 0:
            frame = store.frame(begin)
            received += frame["low"][0]
            begin = frame["end"]
    assert received == [float(i) for i in range(begin)]


def test_a_page_opened_late_gets_the_last_half_minute_at_most():
    stream = Stream(("a",))
    for index in range(3 * MAX_BINS):
        stream.add(index * BIN_NS, (1.0,))
    frame = TimeSeriesStore({"side": stream}).frame(0)
    assert len(frame["low"][0]) == MAX_BINS
    assert None not in frame["low"][0]


def test_a_jump_of_the_stamps_begins_a_new_epoch():
    stream = Stream(("a",))
    store = TimeSeriesStore({"side": stream})
    stream.add(100_000_000_000, (1.0,))
    epoch = store.epoch
    stream.add(5_000_000_000, (2.0,))
    assert store.epoch == epoch + 1
    assert store.end < 1000


def test_the_time_axis_follows_stamps_that_step_back_while_another_topic_is_silent():
    ended, repeated = Stream(("a",)), Stream(("b",))
    store = TimeSeriesStore({"ended": ended, "repeated": repeated})
    for index in range(5000, 5100):
        ended.add(index * BIN_NS, (1.0,))
        repeated.add(index * BIN_NS, (2.0,))
    epoch = store.epoch
    for index in range(1000, 1050):
        repeated.add(index * BIN_NS, (3.0,))
    assert store.epoch > epoch
    assert store.end == 1049 - MAX_LAG
    frame = store.frame(1000)
    assert frame["low"] == [[None] * 46, [3.0] * 46]
    ended.add(1049 * BIN_NS, (4.0,))
    for index in range(1050, 1060):
        repeated.add(index * BIN_NS, (3.0,))
    assert store.frame(1049)["low"] == [[4.0] * 7, [3.0] * 7]


def test_a_number_without_a_json_representation_is_null():
    stream = Stream(("a",))
    for index in range(10):
        stream.add(index * BIN_NS, (math.nan if index == 2 else 1.0,))
    text = json.dumps(TimeSeriesStore({"side": stream}).frame(0), allow_nan=False)
    assert json.loads(text)["low"][0][2] is None


def test_the_status_label_depends_on_status_and_age():
    assert status_label(None, math.inf) == "WAITING"
    assert status_label(2, 0.1) == "VALID"
    assert status_label(5, 0.1) == "FAULT"
    assert status_label(2, 0.6) == "SILENT"
    assert status_label(99, 0.1) == "UNKNOWN"


def test_lost_frames_are_the_gaps_of_the_counter_over_batches():
    state = count_lost([10, 11, 13], None)
    assert state == (13, 1)
    state = count_lost([14, 20], state)
    assert state == (20, 6)
    assert count_lost([0, 1], state) == (1, 6)


def test_delays_are_summarised_unless_the_clocks_differ():
    near, far = Delays(), Delays()
    for k in range(1, 101):
        near.add(k * 1_000_000)
        far.add(10**18)
    assert near.to_json() == {"p50": 51.0, "p99": 99.0, "max": 100.0}
    assert far.to_json() == {}


def test_a_quantity_comes_with_its_standard_deviation():
    assert quantity(2.0, 0.25, True) == {"value": 2.0, "std": 0.5, "valid": True}


def event_lines(events):
    return [f"{one['source']}: {one['text']} x{one['count']} {one['severity']}" for one in events.to_json()]


def test_the_state_has_every_quantity_with_its_validity_and_every_diagnostic():
    state = filled_model().to_json(10.1)
    side = state["transmission_1"]
    assert side["status"] == "VALID"
    assert side["stiffness"] == {"value": 2000.0, "std": 20.0, "valid": True}
    assert side["coefficients"]["k2"] == {"value": 267.2, "std": 2.0, "valid": True}
    assert side["coefficients"]["d2"]["valid"] is False
    assert (side["lost"], side["reset_reason"], side["observability"]) == (2, "INNOVATION", ["inertia: move faster"])
    assert side["stamp_ns"] == "990000000"
    assert state["transmission_2"]["status"] == "WAITING"
    assert state["diagnostics"] == {"driver": "bus off"}


def test_a_quantity_is_not_valid_after_the_timeout():
    side = filled_model().to_json(10.6)["transmission_1"]
    assert side["status"] == "SILENT"
    assert (side["stiffness"]["valid"], side["coefficients"]["k2"]["valid"]) == (False, False)


def test_the_elastic_law_has_its_name_knots_and_the_covariance_of_neighbours():
    model = filled_model()
    side = model.transmissions["transmission_1"]
    assert model.to_json(10.1)["transmission_1"]["elastic_law"] is None
    state = EstimatorState(elastic_law="any spring (97 %)", elastic_law_valid=True)
    state.elastic_deflection, state.elastic_ln_stiffness = [0.004, 0.006, 0.009], [7.0, 7.5, math.log(2e3)]
    state.elastic_ln_stiffness_covariance = [4.0, 1.0, 9.0, 1.0, 5.0, 2.0, 9.0, 2.0, 6.0]
    side.add_state(serialize_message(state))
    assert model.to_json(10.1)["transmission_1"]["elastic_law"] == {
        "name": "any spring (97 %)", "valid": True, "deflection": [0.004, 0.006, 0.009],
        "ln_stiffness": [7.0, 7.5, 7.6009], "variance": [4.0, 5.0, 6.0], "covariance": [1.0, 2.0],
    }  # fmt: skip
    assert not model.to_json(11.0)["transmission_1"]["elastic_law"]["valid"]
    state.elastic_ln_stiffness_covariance = [4.0] * 4
    side.add_state(serialize_message(state))
    assert model.to_json(10.1)["transmission_1"]["elastic_law"] is None


def test_the_mode_of_the_estimator_is_a_text():
    model = filled_model()
    model.transmissions["transmission_1"].add_state(
        serialize_message(EstimatorState(mode=EstimatorState.MODE_GENERAL_SUSPENDED))
    )
    assert model.to_json(10.1)["transmission_1"]["mode"] == "general suspended"
    assert model.to_json(11.0)["transmission_1"]["mode"] == ""


def test_a_diagnostic_ends_when_its_node_is_back_to_ok():
    model = filled_model()
    model.add_diagnostics(diagnostic(0, ""), 2 * S, 11.0, "/vsa/")
    assert model.to_json(10.1)["diagnostics"] == {}
    assert event_lines(model.events)[-2:] == ["driver: bus off x1 error", "driver: back to OK x1 ok"]


def test_a_diagnostic_ends_three_seconds_after_the_last_message_of_its_node():
    model = filled_model()
    model.add_diagnostics(diagnostic(2, "bus off"), 3 * S, 12.0, "/vsa/")
    model.check_timeouts(14.9, 6 * S)
    assert model.to_json(14.9)["diagnostics"] == {"driver": "bus off"}
    model.check_timeouts(15.1, 7 * S)
    assert model.to_json(15.1)["diagnostics"] == {}
    assert event_lines(model.events)[-1] == "driver: no diagnostics for 3 s x1 error"


def test_reasons_range_and_angle_end_with_the_timeout():
    model = filled_model()
    side = model.transmissions["transmission_1"]
    side.add_state(serialize_message(EstimatorState(reason="force sensor stuck", observability=["d2: move faster"])))
    state, later = model.to_json(10.4), model.to_json(10.6)
    assert (state["transmission_1"]["reason"], state["transmission_1"]["observability"]) == (
        "force sensor stuck", ["d2: move faster"]
    )  # fmt: skip
    assert (later["transmission_1"]["reason"], later["transmission_1"]["observability"]) == ("", [])
    joint = state["joint"]
    assert (joint["reason"], joint["range"], joint["angle"]) == ("one tendon is slack", [0.5, 2.0], 0.25)
    assert (later["joint"]["reason"], "range" in later["joint"], later["joint"]["angle"]) == ("", False, None)


def test_diagnostics_of_another_joint_are_ignored():
    model = filled_model()
    model.add_diagnostics(diagnostic(2, "no sample", "/left/driver"), S, 10.0, "/vsa/")
    assert model.to_json(10.1)["diagnostics"] == {"driver": "bus off"}


def test_events_of_a_transmission_have_their_times():
    model = ViewModel(SIDE, STATE, JOINT)
    side = model.transmissions["transmission_2"]
    for stamp_ns, status in ((1 * S, 1), (2 * S, 2), (3 * S, 4)):
        side.add_impedance(impedance(stamp_ns, status=status), 1e-9 * stamp_ns)
    for rejected in (5, 5, 12):
        state = EstimatorState(force_rejected=rejected, reset_count=3)
        set_stamp(state.header.stamp, 3 * S)
        side.add_state(serialize_message(state))
    side.add_counters(counters(3 * S, 1, 2))
    side.add_counters(counters(4 * S, 5, 6))
    model.check_timeouts(9.0, 9 * S)
    assert event_lines(model.events) == [
        "transmission_2: WAITING → CONVERGING x1 info",
        "transmission_2: CONVERGING → VALID x1 ok",
        "transmission_2: VALID → STALE x1 warning",
        "transmission_2: force rejected by the gate x7 warning",
        "transmission_2: sample lost on the bus x2 error",
        "transmission_2: STALE → SILENT x1 error",
    ]
    assert [one["time"] for one in model.events.to_json()] == [1.0, 2.0, 3.0, 3.0, 4.0, 9.0]


def test_a_repetition_increments_the_count_and_a_later_one_is_a_new_event():
    events = Events()
    status, resets = StatusTracker("joint", events), CounterWatch("joint", events)
    for k in range(10):
        status.update("STALE" if k % 2 else "VALID", k * S // 10)
    resets.update("reset", 4, S)
    resets.update("reset", 5, 2 * S)
    resets.update("reset", 0, 3 * S)  # the node has restarted
    resets.update("reset", 1, 8 * S)
    assert event_lines(events) == [
        "joint: WAITING → VALID x1 ok",
        "joint: VALID → STALE x5 warning",
        "joint: STALE → VALID x4 ok",
        "joint: reset x1 warning",
        "joint: reset x1 warning",
    ]


@pytest.mark.parametrize(
    ("published", "age", "expected"),
    [
        (set(), math.inf, "no publisher below /vsa in ROS domain 7: start the nodes"),
        ({"joint_impedance"}, math.inf, "transmission 1: no publisher of /vsa/transmission_1/impedance"),
        ({"joint_impedance"}, 9.0, "transmission_1/impedance; its node has ended"),
        ({"transmission_1/impedance"}, math.inf, "no publisher of /vsa/transmission_1/force; is the driver running?"),
        ({"transmission_1/impedance", "transmission_1/force"}, math.inf, "/vsa/transmission_1/encoder; is the driver"),
        (
            {"transmission_1/impedance", "transmission_1/force", "transmission_1/encoder"},
            12.4,
            "no sample has arrived for 12 s; is the bus connected?",
        ),
    ],
)
def test_missing_data_has_a_reason(published, age, expected):
    status = {"joint": "SILENT", "transmission_1": "WAITING"}
    assert any(expected in line for line in no_data_reasons("/vsa", "7", status, dict.fromkeys(status, age), published))


def test_there_is_no_reason_for_a_source_with_data():
    assert no_data_reasons("/vsa", "0", {"joint": "VALID"}, {"joint": 0.1}, {"joint_impedance"}) == []


def test_the_force_rate_of_a_ramp_converges_to_its_slope():
    model = ViewModel(SIDE, STATE, JOINT)
    for k in range(3000):
        model.transmissions["transmission_1"].add_impedance(impedance(k * 10**6, force=8.0 * k * 1e-3), 0.0)
    frame, channels = model.series.frame(0), model.series.channels
    assert frame["low"][channels.index("transmission_1/force_rate")][-1] == pytest.approx(8.0, rel=1e-3)
