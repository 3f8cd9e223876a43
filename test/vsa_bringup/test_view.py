"""The live page: its bins and words against literal values, its server, and the page itself in a real browser."""

import asyncio
import json
import math
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import paper_run
import pytest
import rclpy
from aiohttp import WSMsgType, WSServerHandshakeError
from aiohttp.test_utils import TestClient, TestServer
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState
from vsa_bringup.view_core import HELD, KEPT, LATE, WIDTH_NS, Board, Delays, Stream, lost, quantity, status_word
from vsa_bringup.view_server import Server
from vsa_bringup.view_show import Show
from vsa_bringup.view_wire import Wire
from vsa_common.stamps import set_stamp
from vsa_msgs.msg import CaptureCounters, EstimatorState, JointImpedance, TransmissionImpedance

SIDE_FIELDS = TransmissionImpedance.get_fields_and_field_types()
JOINT_FIELDS = JointImpedance.get_fields_and_field_types()


def impedance(stamp_ns=10**9, frame="transmission_1", **values):
    message = TransmissionImpedance(**values)
    message.header.frame_id = frame
    set_stamp(message.header.stamp, stamp_ns)
    return serialize_message(message)


@pytest.mark.parametrize("frame", ["", "a", "transmission_1", "left/transmission_2"])
def test_numbers_come_out_of_the_bytes_as_they_went_into_the_message(frame):
    wire = Wire(SIDE_FIELDS)
    given = {name: 0.1 * i for i, (name, kind) in enumerate(SIDE_FIELDS.items()) if kind == "double"}
    stamp_ns, values = wire.read(
        impedance(1_234_567_890_123, frame, status=3, reset_count=70_000, damping_valid=True, **given)
    )
    found = dict(zip(wire.names, values, strict=True))
    assert stamp_ns == 1_234_567_890_123
    assert {name: found[name] for name in given} == given
    assert (found["status"], found["reset_count"], found["damping_valid"], found["force_valid"]) == (
        3,
        70_000,
        True,
        False,
    )


def test_a_joint_message_is_read_up_to_its_first_text():
    wire = Wire(JOINT_FIELDS)
    data = serialize_message(JointImpedance(stiffness=2.5, tension=[3.0, 4.0], status=2, reason="a text"))
    found = dict(zip(wire.names, wire.read(data)[1], strict=True))
    assert (found["stiffness"], found["tension_1"], found["tension_2"], found["status"]) == (2.5, 3.0, 4.0, 2)
    assert "reason" not in found


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


def filled_show():
    show = Show(SIDE_FIELDS, JOINT_FIELDS)
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
    side.take_state(state, 99 * 10**7)
    side.take_counters(CaptureCounters(counter=[1, 2, 5]))
    show.take_diagnostics(
        DiagnosticArray(status=[DiagnosticStatus(level=bytes([2]), name="driver", message="bus off")])
    )
    return show


def test_the_table_has_every_quantity_with_its_validity_and_every_complaint():
    words = filled_show().words(10.1)
    side = words["transmission_1"]
    assert side["status"] == "VALID"
    assert side["stiffness"] == {"value": 2000.0, "std": 20.0, "valid": True}
    assert side["coefficients"]["k2"] == {"value": 267.2, "std": 2.0, "valid": True}
    assert side["coefficients"]["d2"]["valid"] is False
    assert (side["lost"], side["reset_reason"], side["observability"]) == (2, "INNOVATION", ["inertia: move faster"])
    assert words["transmission_2"]["status"] == "WAITING"
    assert words["complaints"] == {"driver": "bus off"}


def test_a_complaint_goes_when_the_node_is_well_again():
    show = filled_show()
    show.take_diagnostics(DiagnosticArray(status=[DiagnosticStatus(level=bytes([0]), name="driver")]))
    assert show.words(10.1)["complaints"] == {}


def test_the_force_rate_of_a_ramp_comes_to_its_slope():
    show = Show(SIDE_FIELDS, JOINT_FIELDS)
    for k in range(3000):
        show.sides["transmission_1"].take_impedance(impedance(k * 10**6, force=8.0 * k * 1e-3), 0.0)
    frame, channels = show.board.frame(0), show.board.channels
    assert frame["low"][channels.index("transmission_1/force_rate")][-1] == pytest.approx(8.0, rel=1e-3)


async def talk(server, headers=None, messages=2):
    async with TestClient(TestServer(server.application)) as client:
        page = await client.get("/")
        async with client.ws_connect("/ws", headers=headers or {}) as socket:
            found = [await socket.receive() for _ in range(messages)]
        missing = await client.get("/view.py")
        return await page.text(), [json.loads(one.data) for one in found if one.type is WSMsgType.TEXT], missing.status


def test_a_new_page_is_told_the_channels_and_then_all_that_is_kept():
    show = filled_show()
    page, (hello, frame), missing = asyncio.run(talk(Server(show.board, lambda: show.words(10.1), "/vsa")))
    assert "view.js" in page
    assert hello["hello"] == "/vsa"
    assert hello["channels"] == show.board.channels
    assert len(frame["low"]) == len(hello["channels"])
    assert frame["end"] - frame["begin"] == len(frame["low"][0])
    assert frame["words"]["transmission_1"]["status"] == "VALID"
    assert missing == 404


def test_a_page_of_another_site_may_not_look_in():
    show = filled_show()
    with pytest.raises(WSServerHandshakeError, match="403"):
        asyncio.run(talk(Server(show.board, dict, "/vsa"), headers={"Origin": "http://elsewhere.example"}))


# In a real browser.

CHROMIUM, CHROMEDRIVER = shutil.which("chromium"), shutil.which("chromedriver")
FLAGS = (
    "--headless --no-sandbox --disable-gpu --disable-background-networking --disable-component-update --disable-sync "
    "--no-first-run --window-size=1200,1000"
)


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


class Rig:
    """Publishes the paper's joint, at 100 Hz, until it is told to stop."""

    def __init__(self):
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=int(os.environ["ROS_DOMAIN_ID"]))
        self.node = rclpy.create_node("rig", namespace="/vsa", context=self.context)
        self.done, self.silent = threading.Event(), threading.Event()
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self):
        kinds = {"impedance": TransmissionImpedance, "estimator_state": EstimatorState, "encoder": JointState}
        publishers = {
            (side, leaf): self.node.create_publisher(kind, f"transmission_{side}/{leaf}", 100)
            for side in (1, 2)
            for leaf, kind in kinds.items()
        }
        joints = self.node.create_publisher(JointImpedance, "joint_impedance", 100)
        while not self.done.wait(0.01):
            if self.silent.is_set():
                continue
            now = time.time_ns()
            for (side, leaf), publisher in publishers.items():
                publisher.publish(self.message(side, kinds[leaf], now))
            joint = JointImpedance(stiffness=0.75, stiffness_variance=1e-4, stiffness_valid=True, status=2)
            set_stamp(joint.header.stamp, now)
            joints.publish(joint)

    def message(self, side, kind, now):
        offset, _, k2, *_ = paper_run.LAWS[side]
        values = {
            TransmissionImpedance: {"force": 30.0, "stiffness": 2345.0, "stiffness_valid": True, "status": 2},
            EstimatorState: {"k2": k2, "k2_valid": True, "force_offset": offset, "reason": f"reason {side}"},
            JointState: {"position": [0.008]},
        }[kind]
        message = kind(**values)
        set_stamp(message.header.stamp, now)
        return message

    def close(self):
        self.done.set()
        self.thread.join()
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)


@pytest.fixture(scope="module")
def isolated():
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_DOMAIN_ID", str(100 + os.getpid() % 100))
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        yield


def start_view(port):
    command = [sys.executable, "-m", "vsa_bringup.view", "--port", str(port)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert f"http://127.0.0.1:{port}/" in process.stdout.readline()
    return process


@pytest.fixture(scope="module")
def browser():
    if not (CHROMIUM and CHROMEDRIVER):
        pytest.skip("needs chromium and chromedriver (Debian: apt install chromium chromium-driver)")
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for flag in FLAGS.split():
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(CHROMEDRIVER))
    yield driver
    driver.quit()


def eventually(browser, script, wanted, seconds=30):
    from selenium.webdriver.support.ui import WebDriverWait

    WebDriverWait(browser, seconds, 0.1).until(lambda one: one.execute_script(f"return {script}") == wanted, script)


def text_of(name):
    return f"document.querySelector('{name}')?.textContent"


def test_the_page_shows_the_joint_live_notices_silence_and_reconnects(isolated, browser):
    port = free_port()
    process, rig = start_view(port), Rig()
    try:
        browser.get(f"http://127.0.0.1:{port}/")
        for chip in ("status_transmission_1", "status_transmission_2", "status_joint"):
            eventually(browser, text_of(f"#{chip} b"), "VALID")
        eventually(browser, text_of("#row_k2 td:nth-child(2)"), "0.2672 ± 0")
        eventually(browser, text_of("#row_stiffness td:nth-child(3)"), "2.345 ± 0")
        assert browser.execute_script(f"return {text_of('#numbers b')}") == "0.75"
        assert "transmission 2: reason 2" in browser.execute_script(f"return {text_of('#remarks')}")
        eventually(browser, "Number(document.body.dataset.bins) > 50", True)
        inked = """[...document.querySelectorAll('.plot canvas')].slice(0, 1).every(c =>
            c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some(v => v > 0))"""
        assert browser.execute_script(f"return {inked}")
        rig.silent.set()
        eventually(browser, text_of("#status_joint b"), "SILENT")
        rig.silent.clear()
        eventually(browser, text_of("#status_joint b"), "VALID")
        assert [one for one in browser.get_log("browser") if one["level"] == "SEVERE"] == []
        process.send_signal(signal.SIGINT)
        assert process.wait(10) == 0
        eventually(browser, "document.querySelector('#link').dataset.word", "LOST")
        process = start_view(port)
        eventually(browser, "document.querySelector('#link').dataset.word", "LIVE")
        eventually(browser, text_of("#status_joint b"), "VALID")
    finally:
        rig.close()
        process.kill()
        process.wait()


def test_nothing_on_a_narrow_page_sticks_out(isolated, browser):
    port = free_port()
    process = start_view(port)
    try:
        size = {"width": 400, "height": 800, "deviceScaleFactor": 1, "mobile": True}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        browser.get(f"http://127.0.0.1:{port}/")
        eventually(browser, "document.querySelector('#link').dataset.word", "LIVE")
        assert browser.execute_script("return document.documentElement.scrollWidth") <= 400
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        process.kill()
        process.wait()


def test_a_port_that_is_taken_is_one_line(isolated):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        command = [sys.executable, "-m", "vsa_bringup.view", "--port", str(taken.getsockname()[1])]
        ended = subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)
    assert ended.returncode == 1
    assert ended.stderr.count("\n") == 1
    assert "in use" in ended.stderr


def test_the_vendored_library_lies_beside_its_licence():
    static = Path(sys.modules["vsa_bringup"].__file__).parent / "static"
    assert "MIT" in (static / "uPlot.LICENSE.txt").read_text()
    assert "uPlot" in (static / "uPlot.iife.min.js").read_text()[:200]
