# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The live page in a real browser, with a publisher of the test and with the whole demo."""

import json
import math
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import rclpy
from host import undisturbed
from selenium import webdriver
from selenium.webdriver import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait
from sensor_msgs.msg import JointState
from vsa_common.ros.subprocesses import executable
from vsa_common.stamps import nanoseconds, set_stamp
from vsa_estimator.offline.elastic_law import KnotLaw
from vsa_msgs.msg import EstimatorState, JointImpedance, TransmissionImpedance
from vsa_msgs.srv import InjectFailure

pytestmark = pytest.mark.live

CHROMIUM, CHROMEDRIVER = shutil.which("chromium"), shutil.which("chromedriver")
FLAGS = (
    "--headless --no-sandbox --disable-gpu --disable-background-networking --disable-component-update --disable-sync "
    "--no-first-run --window-size=1200,1000"
)
PHONE = {"width": 400, "height": 800, "deviceScaleFactor": 1, "mobile": True}


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


LAW = {  # of transmission 2: knots, ln stiffness and its covariance; the joint's position passes all knots
    "elastic_law": "any spring (97 %)", "elastic_law_valid": True, "elastic_force": 20.0,
    "elastic_deflection": [0.004, 0.006, 0.009, 0.012], "elastic_ln_stiffness": [7.0, 7.6, 8.0, 8.1],
    "elastic_ln_stiffness_covariance": [
        4e-3, 1e-3, 0.0, 0.0, 1e-3, 1e-3, 1e-4, 0.0, 0.0, 1e-4, 1e-3, 1e-3, 0.0, 0.0, 1e-3, 9e-3,
    ],
}  # fmt: skip


class Publisher:
    """The paper's joint at 100 Hz, until `close`."""

    def __init__(self, space="/vsa", stiffness=0.75):
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=int(os.environ["ROS_DOMAIN_ID"]))
        self.node = rclpy.create_node("rig", namespace=space, context=self.context)
        self.stiffness, self.valid = stiffness, True
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
            joint = JointImpedance(stiffness=self.stiffness, stiffness_variance=1e-4, stiffness_valid=self.valid)
            joint.stiffness_range_valid, joint.stiffness_min, joint.stiffness_max, joint.status = True, 0.5, 2.0, 2
            set_stamp(joint.header.stamp, now)
            joints.publish(joint)

    def message(self, side, kind, now):
        position = 0.008 + 0.004 * math.sin(1e-9 * now)
        values = {
            TransmissionImpedance: {
                "force": 30.0, "stiffness": 2345.0, "stiffness_valid": True, "status": 2, "deflection": position,
            },
            EstimatorState: {
                "k2": {1: 267.2, 2: 165.6}[side], "k2_valid": True, "reason": f"reason {side}",
                **(LAW if side == 2 else {}),
            },
            JointState: {"position": [0.008]},
        }[kind]  # fmt: skip
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
    command = [sys.executable, "-m", "vsa_tools.view.command", "--port", str(port)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert f"http://127.0.0.1:{port}/" in process.stdout.readline()
    return process


@pytest.fixture
def browser():
    if not (CHROMIUM and CHROMEDRIVER):
        pytest.skip("needs chromium and chromedriver (Debian: apt install chromium chromium-driver)")
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for flag in FLAGS.split():
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(CHROMEDRIVER))
    yield driver
    driver.quit()


def eventually(browser, script, wanted, seconds=30):
    WebDriverWait(browser, seconds, 0.05).until(lambda one: one.execute_script(f"return {script}") == wanted, script)


def text_of(name):
    return f"document.querySelector('{name}')?.textContent"


def displayed_text(browser, name):
    return browser.execute_script(f"return {text_of(name)}")


def errors(browser):
    return [one["message"] for one in browser.get_log("browser") if one["level"] == "SEVERE"]


def requested(browser):
    """Every address that the page requested, WebSockets included."""
    found = set()
    for entry in browser.get_log("performance"):
        event = json.loads(entry["message"])["message"]
        if event["method"] == "Network.requestWillBeSent":
            found.add(event["params"]["request"]["url"])
        elif event["method"] == "Network.webSocketCreated":
            found.add(event["params"]["url"])
    return found


def test_the_page_shows_live_data_detects_a_timeout_and_reconnects(isolated, browser):
    port = free_port()
    process, rig = start_view(port), Publisher()
    try:
        browser.get(f"http://127.0.0.1:{port}/")
        for chip in ("status_transmission_1", "status_transmission_2", "status_joint"):
            eventually(browser, text_of(f"#{chip} b"), "VALID")
        eventually(browser, text_of("#row_k2 td:nth-child(2)"), "0.2672 ± 0 valid")
        eventually(browser, text_of("#row_stiffness td:nth-child(3)"), "2.345 ± 0 valid")
        assert displayed_text(browser, "#row_damping td:nth-child(2)") == "0 ± 0 not valid"
        assert displayed_text(browser, "#numbers b") == "0.750"
        assert displayed_text(browser, "#numbers span") == "± 0.020 N m/rad "
        assert displayed_text(browser, "#row_elastic_law td:nth-child(2)") == "–"
        assert displayed_text(browser, "#row_elastic_law td:nth-child(3)") == "any spring (97 %) valid"
        assert "transmission 2: reason 2" in displayed_text(browser, "#remarks")
        assert browser.execute_script("return document.querySelector('#no_data').hidden")
        eventually(browser, "Number(document.body.dataset.bins) > 50", True)
        drawn = """[...document.querySelectorAll('.plot canvas')].slice(0, 1).every(c =>
            c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some(v => v > 0))"""
        assert browser.execute_script(f"return {drawn}")
        eventually(browser, "document.querySelector('#gauge').hidden", False)
        rig.valid = False
        eventually(browser, "document.querySelector('#gauge').hidden", True)
        rig.valid = True
        rig.silent.set()
        eventually(browser, text_of("#status_joint b"), "SILENT")
        eventually(browser, f"{text_of('#no_data')}.includes('no publisher of /vsa/transmission_1/force')", True)
        assert displayed_text(browser, "#row_stiffness td:nth-child(3)") == "2.345 ± 0 not valid"
        eventually(browser, f"{text_of('#events')}.includes('joint: VALID → SILENT')", True)
        rig.silent.clear()
        eventually(browser, text_of("#status_joint b"), "VALID")
        assert errors(browser) == []
        process.send_signal(signal.SIGINT)
        assert process.wait(10) == 0
        eventually(browser, "document.querySelector('#link').dataset.status", "LOST")
        assert "trying again" in displayed_text(browser, "#no_data")
        process = start_view(port)
        eventually(browser, "document.querySelector('#link').dataset.status", "LIVE")
        eventually(browser, text_of("#status_joint b"), "VALID")
    finally:
        rig.close()
        process.kill()
        process.wait()


def test_without_frames_nothing_is_shown_as_valid_and_the_page_reconnects(isolated, browser):
    port = free_port()
    process, rig = start_view(port), Publisher()
    chips = ("status_transmission_1", "status_transmission_2", "status_joint")
    try:
        browser.get(f"http://127.0.0.1:{port}/")
        for chip in chips:
            eventually(browser, text_of(f"#{chip} b"), "VALID")
        eventually(browser, text_of("#row_stiffness td:nth-child(3)"), "2.345 ± 0 valid")
        process.send_signal(signal.SIGSTOP)  # the connection stays open
        eventually(browser, "document.querySelector('#link').dataset.status", "LOST", 10)
        assert [displayed_text(browser, f"#{chip} b") for chip in chips] == ["SILENT"] * 3
        assert displayed_text(browser, "#row_stiffness td:nth-child(3)") == "2.345 ± 0 not valid"
        assert browser.execute_script("return document.querySelectorAll('.tag.valid').length") == 0
        assert "trying again" in displayed_text(browser, "#no_data")
        process.send_signal(signal.SIGCONT)
        eventually(browser, "document.querySelector('#link').dataset.status", "LIVE")
        for chip in chips:
            eventually(browser, text_of(f"#{chip} b"), "VALID")
    finally:
        rig.close()
        process.kill()
        process.wait()


def test_the_elastic_law_of_the_page_is_that_of_the_report(isolated, browser):
    port = free_port()
    process = start_view(port)
    try:
        browser.get(f"http://127.0.0.1:{port}/")
        knots, ln_stiffness = LAW["elastic_deflection"], LAW["elastic_ln_stiffness"]
        covariance = np.reshape(LAW["elastic_ln_stiffness_covariance"], (4, 4))
        sent = {
            "deflection": knots, "ln_stiffness": ln_stiffness, "variance": np.diag(covariance).tolist(),
            "covariance": np.diag(covariance, 1).tolist(),
        }  # fmt: skip
        drawn = browser.execute_async_script(
            "const [law, done] = arguments; import('./plots.js').then((m) => done(m.lawPoints(law, 2, 13)));", sent
        )
        x, stiffness, low, high = np.array(drawn).T
        law = KnotLaw(np.array(knots), np.array(ln_stiffness), covariance, 20.0)
        assert (x[0], x[-1]) == pytest.approx((2.0, 13.0), rel=1e-12)
        assert 1e3 * stiffness == pytest.approx(law.stiffness(1e-3 * x), rel=1e-9)
        assert [1e3 * low, 1e3 * high] == [pytest.approx(one, rel=1e-9) for one in law.band(1e-3 * x)]
    finally:
        process.kill()
        process.wait()


def test_a_page_can_be_paused_zoomed_and_switched_to_another_joint(isolated, browser):
    port = free_port()
    process, right, left = start_view(port), Publisher(), Publisher("/left/arm", 1.25)
    try:
        browser.get(f"http://127.0.0.1:{port}/")
        eventually(browser, text_of("#numbers b"), "0.750")
        eventually(browser, "document.querySelector('#joint').options.length", 2)
        eventually(browser, "Number(document.body.dataset.bins) > 100", True)
        over = browser.find_element(By.CSS_SELECTOR, ".u-over")
        browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", over)
        ActionChains(browser).move_to_element(over).click_and_hold().move_by_offset(60, 0).release().perform()
        assert displayed_text(browser, "#pause") == "resume"
        bins = browser.execute_script("return document.body.dataset.bins")
        end = browser.execute_script("return document.body.dataset.end")
        right.stiffness = 0.5
        eventually(browser, f"Number(document.body.dataset.end) > {end}", True)
        assert displayed_text(browser, "#numbers b") == "0.750"
        assert browser.execute_script("return document.body.dataset.bins") == bins
        browser.execute_script("document.querySelector('#zoom_out').click()")
        eventually(browser, text_of("#numbers b"), "0.500")
        eventually(browser, f"document.body.dataset.bins != {bins}", True)
        browser.execute_script(
            "const one = document.querySelector('#joint');"
            "one.value = '/left/arm'; one.dispatchEvent(new Event('change'))"
        )
        eventually(browser, text_of("#numbers b"), "1.250")
        assert browser.execute_script("return location.hash") == "#/left/arm"
        assert errors(browser) == []
    finally:
        right.close()
        left.close()
        process.kill()
        process.wait()


class Observer:
    """Messages of a subscriber besides the page, by stamp; and the injection of sensor failures."""

    def __init__(self, domain):
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = rclpy.create_node("observer", namespace="/vsa", context=self.context)
        self.received = {}
        for kind, topic in ((JointImpedance, "joint_impedance"), (TransmissionImpedance, "transmission_1/impedance")):
            self.node.create_subscription(kind, topic, lambda one, key=topic: self.add(key, one), 1000)
        self.failure = self.node.create_client(InjectFailure, "rig_simulator/failure")
        self.done = threading.Event()
        self.executor = rclpy.executors.SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.thread = threading.Thread(target=self.spin, daemon=True)
        self.thread.start()

    def spin(self):
        while not self.done.is_set():
            self.executor.spin_once(timeout_sec=0.1)

    def add(self, key, message):
        self.received[key, str(nanoseconds(message.header.stamp))] = message

    def inject(self, failure):
        assert self.failure.wait_for_service(10.0)
        answer = self.failure.call(InjectFailure.Request(failure=failure))
        assert answer.success, answer.message

    def close(self):
        self.done.set()
        self.thread.join()
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)


def domain_of(parameters):
    """ROS domain of the processes with this parameter file."""
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if str(parameters).encode() in (folder / "cmdline").read_bytes():
                found = re.search(rb"ROS_DOMAIN_ID=(\d+)", (folder / "environ").read_bytes())
                if found:
                    return int(found[1])
        except OSError:
            continue
    raise AssertionError("no process of the demo")


def matches(text, value):
    """Whether "1.25 ± 0.02 valid" is `value`, to the displayed digits."""
    number = text.split(" ±")[0].replace("−", "-")
    last_digit = 10.0 ** -len(number.partition(".")[2])
    return float(number) == pytest.approx(value, rel=5e-3, abs=0.51 * last_digit)


def displayed(browser):
    """Stamp and stiffness of the joint and of transmission_1, in one script call."""
    return browser.execute_script(
        "const text = (name) => document.querySelector(name).textContent, n = document.querySelector('#numbers'),"
        " c = document.querySelector('#coefficients');"
        "return [n.dataset.stamp, text('#numbers b'), c.dataset.stamp1, text('#row_stiffness td:nth-child(2)')]"
    )


def seconds_until_live(browser, address):
    """Time from the request to status and curves on the page [s]."""
    begin = time.monotonic()
    browser.get(address)
    eventually(browser, "['CONVERGING', 'VALID'].includes(document.querySelector('#status_joint b').textContent)", True)
    eventually(browser, "Number(document.body.dataset.bins) > 0", True)
    return time.monotonic() - begin


def test_the_page_of_the_demo_is_live_correct_local_and_detects_a_stopped_sensor(tmp_path, browser):
    out = tmp_path / "demo"
    command = [executable("vsa_tools", "demo"), "--view", "--duration", "180", "--rate", "200", "--out", str(out)]
    demo = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    observer = None
    try:
        address = re.search(r"http://127\.0\.0\.1:\d+/", demo.stdout.readline())[0]
        assert undisturbed(lambda: seconds_until_live(browser, address), lambda: None, 0.1) < 3.0
        observer = Observer(domain_of(out / "parameters.yaml"))
        eventually(browser, text_of("#status_joint b"), "VALID")
        compared, begin = 0, time.monotonic()
        while compared < 3:
            joint_stamp, joint, side_stamp, side = displayed(browser)
            true_joint = observer.received.get(("joint_impedance", joint_stamp))
            true_side = observer.received.get(("transmission_1/impedance", side_stamp))
            if true_joint and true_side:
                assert matches(joint, true_joint.stiffness)
                assert matches(side, 1e-3 * true_side.stiffness)
                compared += 1
            time.sleep(0.2)
            assert time.monotonic() - begin < 40.0
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", PHONE)
        assert browser.execute_script("return document.documentElement.scrollWidth") <= 400
        inside = "[...document.querySelectorAll('.card')].every((one) => one.scrollWidth <= one.clientWidth)"
        eventually(browser, inside, True)
        observer.inject("can_signal off -i 1")
        eventually(browser, f"['STALE', 'FAULT', 'SILENT'].includes({text_of('#status_transmission_1 b')})", True)
        eventually(browser, f"{text_of('#events')}.includes('transmission 1')", True)
        assert errors(browser) == []
        assert {
            re.sub(r"^\w+://([^/]*)/.*", r"\1", one) for one in requested(browser) if not one.startswith("data:")
        } == {address.split("/")[2]}
    finally:
        if observer:
            observer.close()
        demo.send_signal(signal.SIGINT)
        demo.wait(30)


def test_a_port_in_use_is_a_one_line_error(isolated):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        command = [sys.executable, "-m", "vsa_tools.view.command", "--port", str(taken.getsockname()[1])]
        ended = subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)
    assert ended.returncode == 1
    assert ended.stderr.count("\n") == 1
    assert "in use" in ended.stderr


def test_the_vendored_library_has_its_licence():
    static = Path(sys.modules["vsa_tools.view"].__file__).parent / "static"
    assert "MIT" in (static / "uPlot.LICENSE.txt").read_text()
    assert "uPlot" in (static / "uPlot.iife.min.js").read_text()[:200]
