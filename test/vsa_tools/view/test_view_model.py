"""The state behind the live page: bins, words, events and reasons against literal values; and its server."""

import asyncio
import json
import math
from types import SimpleNamespace

import pytest
from aiohttp import WSMsgType, WSServerHandshakeError
from aiohttp.test_utils import TestClient, TestServer
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.serialization import serialize_message
from vsa_common.stamps import set_stamp
from vsa_msgs.msg import CaptureCounters, EstimatorState, JointImpedance, TransmissionImpedance
from vsa_tools.view.events import Events, Tally, Turns
from vsa_tools.view.reason import why_no_data
from vsa_tools.view.server import Server
from vsa_tools.view.time_series import HELD, KEPT, LATE, WIDTH_NS, Board, Delays, Stream, lost, quantity, status_word
from vsa_tools.view.view_model import Show

SIDE, STATE, JOINT = (k.get_fields_and_field_types() for k in (TransmissionImpedance, EstimatorState, JointImpedance))


def impedance(stamp_ns=10**9, frame="transmission_1", **values):
    message = TransmissionImpedance(**values)
    message.header.frame_id = frame
    set_stamp(message.header.stamp, stamp_ns)
    return serialize_message(message)


def test_a_spike_of_one_sample_in_a_thousand_stays_visible():
    stream = Stream(("force",))
    for k in range(1000):
        stream.add(k * 1_000_000, (500.0 if k == 617 else 1.0,))
    rows = Board({"side": stream}).frame(0)
    assert max(value for value in rows["high"][0]) == 500.0
    assert rows["low"][0][617 // 20] == 1.0
    assert len(rows["low"][0]) == rows["end"] == 1000 * 1_000_000 // WIDTH_NS - 1 - LATE


def test_a_slow_topic_is_held_for_a_quarter_second_and_then_missing():
    fast, slow = Stream(("a",)), Stream(("b",))
    slow.add(0, (7.0,))
    for index in range(60):
        fast.add(index * WIDTH_NS, (1.0,))
    low = Board({"fast": fast, "slow": slow}).frame(0)["low"][1]
    assert low[:HELD] == [7.0] * HELD
    assert low[HELD:] == [None] * (len(low) - HELD)


def test_frames_continue_where_the_last_one_ended():
    stream, begin, seen = Stream(("a",)), 0, []
    board = Board({"side": stream})
    for index in range(200):
        stream.add(index * WIDTH_NS, (float(index),))
        if index % 7 == 0:
            frame = board.frame(begin)
            seen += frame["low"][0]
            begin = frame["end"]
    assert seen == [float(i) for i in range(begin)]


def test_a_page_opened_late_gets_the_last_half_minute_at_most():
    stream = Stream(("a",))
    for index in range(3 * KEPT):
        stream.add(index * WIDTH_NS, (1.0,))
    frame = Board({"side": stream}).frame(0)
    assert len(frame["low"][0]) == KEPT
    assert None not in frame["low"][0]


def test_stamps_that_jump_begin_a_new_era():
    stream = Stream(("a",))
    board = Board({"side": stream})
    stream.add(100_000_000_000, (1.0,))
    era = board.era
    stream.add(5_000_000_000, (2.0,))
    assert board.era == era + 1
    assert board.end < 1000


def test_a_number_that_json_has_no_word_for_is_sent_as_nothing():
    stream = Stream(("a",))
    for index in range(10):
        stream.add(index * WIDTH_NS, (math.nan if index == 2 else 1.0,))
    text = json.dumps(Board({"side": stream}).frame(0), allow_nan=False)
    assert json.loads(text)["low"][0][2] is None


def test_words_say_how_an_estimate_is_to_be_taken():
    assert status_word(None, math.inf) == "WAITING"
    assert status_word(2, 0.1) == "VALID"
    assert status_word(5, 0.1) == "FAULT"
    assert status_word(2, 0.6) == "SILENT"
    assert status_word(99, 0.1) == "UNKNOWN"


def test_lost_frames_are_the_gaps_of_the_counter_over_batches():
    state = lost([10, 11, 13], None)
    assert state == (13, 1)
    state = lost([14, 20], state)
    assert state == (20, 6)
    assert lost([0, 1], state) == (1, 6)


def test_delays_are_summed_up_unless_the_clocks_differ():
    near, far = Delays(), Delays()
    for k in range(1, 101):
        near.add(k * 1_000_000)
        far.add(10**18)
    assert near.words() == {"p50": 51.0, "p99": 99.0, "max": 100.0}
    assert far.words() == {}


def test_a_quantity_comes_with_its_standard_deviation():
    assert quantity(2.0, 0.25, True) == {"value": 2.0, "std": 0.5, "valid": True}


S = 10**9  # [ns]


def complaint(level, text, name="/vsa/driver"):
    return DiagnosticArray(status=[DiagnosticStatus(level=bytes([level]), name=name, message=text)])


def counters(stamp_ns, *numbers):
    message = CaptureCounters(counter=numbers)
    set_stamp(message.header.stamp, stamp_ns)
    return serialize_message(message)


def filled_show():
    show = Show(SIDE, STATE, JOINT)
    side = show.sides["transmission_1"]
    for k in range(100):
        data = impedance(
            k * 10**7,
            force=3.0 + 0.5 * k * 0.01,
            stiffness=2000.0,
            stiffness_variance=400.0,
            stiffness_valid=True,
            status=2,
        )
        side.take_impedance(data, 10.0)
    state = EstimatorState(k2=267.2, k2_variance=4.0, k2_valid=True, reset_count=1, reset_reason=4, samples_fused=100)
    state.observability = ["inertia: move faster"]
    side.take_state(serialize_message(state))
    side.take_counters(counters(S, 1, 2, 5))
    show.take_diagnostics(complaint(2, "bus off"), S, "/vsa/")
    return show


def told(events):
    return [f"{one['who']}: {one['text']} x{one['times']} {one['tone']}" for one in events.words()]


def test_the_table_has_every_quantity_with_its_validity_and_every_complaint():
    words = filled_show().words(10.1)
    side = words["transmission_1"]
    assert side["status"] == "VALID"
    assert side["stiffness"] == {"value": 2000.0, "std": 20.0, "valid": True}
    assert side["coefficients"]["k2"] == {"value": 267.2, "std": 2.0, "valid": True}
    assert side["coefficients"]["d2"]["valid"] is False
    assert (side["lost"], side["reset_reason"], side["observability"]) == (2, "INNOVATION", ["inertia: move faster"])
    assert side["stamp_ns"] == "990000000"
    assert words["transmission_2"]["status"] == "WAITING"
    assert words["complaints"] == {"driver": "bus off"}


def test_nothing_is_called_valid_that_came_too_long_ago():
    side = filled_show().words(10.6)["transmission_1"]
    assert side["status"] == "SILENT"
    assert (side["stiffness"]["valid"], side["coefficients"]["k2"]["valid"]) == (False, False)


def test_a_complaint_goes_when_the_node_is_well_again():
    show = filled_show()
    show.take_diagnostics(complaint(0, ""), 2 * S, "/vsa/")
    assert show.words(10.1)["complaints"] == {}
    assert told(show.events)[-2:] == ["driver: bus off x1 bad", "driver: well again x1 good"]


def test_complaints_of_another_joint_are_not_shown():
    show = filled_show()
    show.take_diagnostics(complaint(2, "no sample", "/left/driver"), S, "/vsa/")
    assert show.words(10.1)["complaints"] == {"driver": "bus off"}


def test_what_happens_to_a_transmission_is_told_with_its_time():
    show = Show(SIDE, STATE, JOINT)
    side = show.sides["transmission_2"]
    for stamp_ns, status in ((1 * S, 1), (2 * S, 2), (3 * S, 4)):
        side.take_impedance(impedance(stamp_ns, status=status), 1e-9 * stamp_ns)
    for rejected in (5, 5, 12):
        state = EstimatorState(force_rejected=rejected, reset_count=3)
        set_stamp(state.header.stamp, 3 * S)
        side.take_state(serialize_message(state))
    side.take_counters(counters(3 * S, 1, 2))
    side.take_counters(counters(4 * S, 5, 6))
    show.watch(9.0, 9 * S)
    assert told(show.events) == [
        "transmission_2: WAITING → CONVERGING x1 note",
        "transmission_2: CONVERGING → VALID x1 good",
        "transmission_2: VALID → STALE x1 warn",
        "transmission_2: force rejected by the gate x7 warn",
        "transmission_2: sample lost on the bus x2 bad",
        "transmission_2: STALE → SILENT x1 bad",
    ]
    assert [one["time"] for one in show.events.words()] == [1.0, 2.0, 3.0, 3.0, 4.0, 9.0]


def test_what_repeats_at_once_is_counted_and_later_told_again():
    events = Events()
    turns, tally = Turns("joint", events), Tally("joint", events)
    for k in range(10):
        turns.turn("STALE" if k % 2 else "VALID", k * S // 10)
    tally.count("reset", 4, S)
    tally.count("reset", 5, 2 * S)
    tally.count("reset", 0, 3 * S)  # the node began anew
    tally.count("reset", 1, 8 * S)
    assert told(events) == [
        "joint: WAITING → VALID x1 good",
        "joint: VALID → STALE x5 warn",
        "joint: STALE → VALID x4 good",
        "joint: reset x1 warn",
        "joint: reset x1 warn",
    ]


@pytest.mark.parametrize(
    ("published", "age", "expected"),
    [
        (set(), math.inf, "nobody publishes below /vsa in ROS domain 7: start the nodes"),
        ({"joint_impedance"}, math.inf, "transmission 1: nobody publishes /vsa/transmission_1/impedance"),
        ({"joint_impedance"}, 9.0, "transmission_1/impedance; its node has ended"),
        ({"transmission_1/impedance"}, math.inf, "nobody publishes /vsa/transmission_1/force; is the driver running?"),
        ({"transmission_1/impedance", "transmission_1/force"}, math.inf, "/vsa/transmission_1/encoder; is the driver"),
        (
            {"transmission_1/impedance", "transmission_1/force", "transmission_1/encoder"},
            12.4,
            "no sample has come for 12 s; is the bus alive?",
        ),
    ],
)
def test_the_page_says_why_it_has_no_data(published, age, expected):
    status = {"joint": "SILENT", "transmission_1": "WAITING"}
    assert any(expected in line for line in why_no_data("/vsa", "7", status, dict.fromkeys(status, age), published))


def test_there_is_no_reason_where_there_is_data():
    assert why_no_data("/vsa", "0", {"joint": "VALID"}, {"joint": 0.1}, {"joint_impedance"}) == []


def test_the_force_rate_of_a_ramp_comes_to_its_slope():
    show = Show(SIDE, STATE, JOINT)
    for k in range(3000):
        show.sides["transmission_1"].take_impedance(impedance(k * 10**6, force=8.0 * k * 1e-3), 0.0)
    frame, channels = show.board.frame(0), show.board.channels
    assert frame["low"][channels.index("transmission_1/force_rate")][-1] == pytest.approx(8.0, rel=1e-3)


def served(show):
    def ear(space):
        if space != "/vsa":
            raise LookupError(f"no joint {space}")
        return SimpleNamespace(show=show, words=lambda: show.words(10.1))

    return Server(SimpleNamespace(space="/vsa", joints=lambda: ["/vsa"], ear=ear))


async def talk(server, path="/ws", headers=None, messages=2):
    async with TestClient(TestServer(server.application)) as client:
        page = await client.get("/")
        async with client.ws_connect(path, headers=headers or {}) as socket:
            found = [await socket.receive() for _ in range(messages)]
        missing = await client.get("/view.py")
        return await page.text(), [json.loads(one.data) for one in found if one.type is WSMsgType.TEXT], missing.status


def test_a_new_page_is_told_the_channels_and_then_all_that_is_kept():
    show = filled_show()
    page, (hello, frame), missing = asyncio.run(talk(served(show)))
    assert "view.js" in page
    assert hello["hello"] == "/vsa"
    assert hello["channels"] == show.board.channels
    assert len(frame["low"]) == len(hello["channels"])
    assert frame["end"] - frame["begin"] == len(frame["low"][0])
    assert frame["words"]["transmission_1"]["status"] == "VALID"
    assert frame["words"]["joints"] == ["/vsa"]
    assert missing == 404


def test_a_page_of_another_site_may_not_look_in():
    with pytest.raises(WSServerHandshakeError, match="403"):
        asyncio.run(talk(served(filled_show()), headers={"Origin": "http://elsewhere.example"}))


def test_a_joint_that_is_not_there_is_refused():
    with pytest.raises(WSServerHandshakeError, match="404"):
        asyncio.run(talk(served(filled_show()), path="/ws?joint=/left"))
