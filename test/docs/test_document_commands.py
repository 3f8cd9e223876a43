# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Every command block of README.md and docs/ is run.

A block is a ```bash fence. It runs as it stands, block after block of a document in one folder, and must end with 0,
unless a comment in the line before it states the exception:

    <!-- tested: with ARGUMENTS -->            ARGUMENTS are appended: a shorter run
    <!-- tested: help -->                      takes minutes: each line runs with --help appended
    <!-- tested: data FILE -->                 the test writes that recording first
    <!-- tested: together until active -->     each line is a process; ended by SIGINT once its node is active
    <!-- tested: together until TEXT, TEXT -->  the same, once each has printed its text
    <!-- tested: beside the rig -->            with a running driver and the simulated rig at rest
    <!-- tested: elsewhere FILE: WORDS -->     run by FILE, which has the block's WORDS
    <!-- tested: hardware -->                  needs a real bus or an installed ROS: only its syntax is checked
"""

import contextlib
import re
import signal
import subprocess
import textwrap
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import rclpy
import yaml
from geometry_msgs.msg import WrenchStamped
from lifecycle_msgs.msg import State
from lifecycle_msgs.srv import GetState
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from vsa_common.config.configuration import load
from vsa_common.io.tables import write_columns
from vsa_common.ros.subprocesses import executable
from vsa_driver.settings import DriverSettings
from vsa_tools.demo.isolation import claim_domain

ROOT = Path(__file__).parents[2]
DOCUMENTS = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
FENCE = re.compile(
    r"^(?P<indent> *)(?:<!-- tested: (?P<rule>[^\n]*) -->\n *)?```(?P<language>\w*)\n(?P<body>.*?)^ *```$", re.M | re.S
)
DEMO = "./vsa demo --view"


@dataclass(frozen=True)
class Block:
    """One fence of a document."""

    name: str
    language: str
    rule: str
    body: str


def blocks_of(document):
    text = document.read_text()
    for match in FENCE.finditer(text):
        line = text.count("\n", 0, match.start("body"))
        body = textwrap.dedent(match["body"])
        yield Block(f"{document.relative_to(ROOT)}:{line}", match["language"], match["rule"] or "", body)


BLOCKS = [block for document in DOCUMENTS for block in blocks_of(document)]
COMMANDS = [block for block in BLOCKS if block.language == "bash"]
WITHOUT_A_RUN = ("help", "elsewhere", "hardware")  # rules


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_every_command_is_in_a_tested_block(document):
    rest = FENCE.sub("", document.read_text())
    assert re.findall(r"^(?: {4,}|\t)(?:\./vsa|ros2|export|python|sudo|pip|git|cp) .*$", rest, flags=re.M) == []
    for block in blocks_of(document):
        assert block.language in ("bash", "yaml", "python", "text"), block.name
        assert block.language != "text" or "./vsa " not in block.body, block.name


def test_the_documents_have_commands():
    assert len(COMMANDS) > 15


@pytest.mark.parametrize("block", [b for b in BLOCKS if b.language == "yaml"], ids=lambda block: block.name)
def test_every_yaml_block_has_valid_driver_parameters(block, tmp_path):
    file = tmp_path / "parameters.yaml"
    file.write_text(block.body)
    assert set(yaml.safe_load(block.body)) == {"/**/driver"}
    load(file, "driver", DriverSettings)


@pytest.fixture(scope="module")
def domain():
    return claim_domain()


@pytest.fixture(scope="module")
def folder(tmp_path_factory, domain):
    """Working folder of the commands: links to the repository, without its outputs."""
    folder = tmp_path_factory.mktemp("reader")
    for name in ("vsa", "src", "examples", "docs"):
        (folder / name).symlink_to(ROOT / name)
    return folder


def run(text, folder, domain, limit=240.0):
    result = subprocess.run(
        ["bash", "-c", f"set -e\n{text}"],
        cwd=folder,
        env=domain.environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=limit,
        check=False,
    )
    assert result.returncode == 0, f"{text}\n{result.stdout}"
    return result.stdout


@pytest.fixture(scope="module")
def recorded(folder, domain):
    """The folder after the README's demo, whose bag the other commands read."""
    block = next(block for block in COMMANDS if block.body.strip() == DEMO)
    run(f"{block.body.strip()} {block.rule.removeprefix('with ')}", folder, domain)
    run("cp src/vsa_bringup/config/paper_rig.yaml my_rig.yaml", folder, domain)
    assert (folder / "vsa_demo" / "report.html").exists()
    return folder


def write_recording(file):
    """Synthetic recording for `calibrate` or `noise`."""
    random = np.random.default_rng(1)
    stamp = np.arange(0.0, 30.0, 0.01)
    if file.name == "gauge.csv":
        tension = 60.0 + 55.0 * np.sin(2 * np.pi * stamp / 15.0)
        columns = {"force": tension / 1.03 + random.normal(0.0, 0.017, stamp.size), "reference": tension}
    else:
        deflection = np.round((0.01 + random.normal(0.0, 1e-5, stamp.size)) / 1e-5) * 1e-5
        columns = {"force": 30.0 + random.normal(0.0, 0.017, stamp.size), "deflection": deflection}
    write_columns(file, {"stamp": stamp, **columns})


@contextlib.contextmanager
def processes(lines, folder, domain):
    """A process for each line with its output in a file; SIGINT ends each with exit code 0."""
    files = [folder / f"output_{i}.txt" for i in range(len(lines))]
    running = []
    for line, file in zip(lines, files, strict=True):
        with file.open("w") as output:
            command = ["bash", "-c", f"exec {line}"]
            running.append(
                subprocess.Popen(command, cwd=folder, env=domain.environment(), stdout=output, stderr=subprocess.STDOUT)
            )
    try:
        yield list(zip(running, files, strict=True))
        for process in running:
            process.send_signal(signal.SIGINT)
        for line, file, process in zip(lines, files, running, strict=True):
            assert process.wait(30.0) == 0, f"{line}\n{file.read_text()}"
    finally:
        for process in running:
            process.kill()


def wait_until_printed(texts, running):
    """Return when each process has printed its text."""
    end = time.monotonic() + 60.0
    for text, (process, file) in zip(texts, running, strict=True):
        while text not in file.read_text():
            assert process.poll() is None, file.read_text()
            assert time.monotonic() < end, f"{text}: {file.read_text()}"
            time.sleep(0.1)


@contextlib.contextmanager
def subscriber_node(domain_id):
    """A node in a ROS domain, and its executor."""
    context = rclpy.Context()
    rclpy.init(context=context, args=[], domain_id=domain_id, signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("reader", namespace="vsa", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    try:
        yield node, executor
    finally:
        node.destroy_node()
        rclpy.shutdown(context=context)


def wait_until_active(names, domain_id):
    """Return when every node is active."""
    with subscriber_node(domain_id) as (node, executor):
        waiting = {name: node.create_client(GetState, f"{name}/get_state") for name in names}
        end = time.monotonic() + 60.0
        while waiting:
            assert time.monotonic() < end, f"{', '.join(waiting)} not active"
            for name, client in list(waiting.items()):
                if client.wait_for_service(0.1):
                    future = client.call_async(GetState.Request())
                    executor.spin_until_future_complete(future, timeout_sec=5.0)
                    if future.done() and future.result().current_state.id == State.PRIMARY_STATE_ACTIVE:
                        del waiting[name]


def wait_for_samples(count, domain_id):
    """Return when the driver has published `count` forces."""
    with subscriber_node(domain_id) as (node, executor):
        received, end = [], time.monotonic() + 60.0
        node.create_subscription(WrenchStamped, "transmission_1/force", received.append, 1000)
        while len(received) < count:
            assert time.monotonic() < end, f"{len(received)} samples"
            executor.spin_once(timeout_sec=0.5)


def name_of(line):
    """The node that a line `./vsa run PACKAGE EXECUTABLE ...` starts."""
    renamed = re.search(r"__node:=(\w+)", line)
    return renamed[1] if renamed else line.split()[3]


@pytest.fixture(scope="module")
def rig():
    """A separate domain with the simulated rig at rest and its driver."""
    domain = claim_domain()
    bus = ["-p", f"bus.options:=['hop_limit=0','port={domain.bus_port}']"]
    rest = ["-p", "rate_hz:=200", "-p", "profile.kind:=hold", "-p", "torque.amplitudes:=[0.0, 0.0]"]
    nodes = {("vsa_simulator", "rig_simulator"): [*rest, *bus], ("vsa_driver", "driver"): bus}
    running = [
        subprocess.Popen([executable(*node), "--ros-args", "-r", "__ns:=/vsa", *arguments], env=domain.environment())
        for node, arguments in nodes.items()
    ]
    try:
        wait_for_samples(300, domain.domain)
        yield domain
    finally:
        for process in running:
            process.send_signal(signal.SIGINT)
        for process in running:
            process.wait(30.0)


def rule_of(block):
    """Name of a block's rule, and the rest."""
    name, _, rest = block.rule.partition(" ")
    return name, rest


def lines_of(block):
    return [line for line in block.body.strip().splitlines() if line.strip() and not line.startswith("#")]


@pytest.mark.parametrize("block", [b for b in COMMANDS if rule_of(b)[0] in WITHOUT_A_RUN], ids=lambda block: block.name)
def test_the_commands_of_a_block_are_valid(block, folder, domain):
    rule, rest = rule_of(block)
    if rule == "hardware":
        subprocess.run(["bash", "-n", "-c", block.body], check=True)
        assert "./vsa" not in block.body
    elif rule == "elsewhere":
        file, _, words = rest.partition(": ")
        assert words in block.body
        assert words in (ROOT / file).read_text()
    else:
        for line in lines_of(block):
            run(f"{line.partition('#')[0].strip()} --help", folder, domain)


@pytest.mark.live
@pytest.mark.parametrize(
    "block", [b for b in COMMANDS if rule_of(b)[0] not in WITHOUT_A_RUN], ids=lambda block: block.name
)
def test_the_commands_of_a_block_run(block, recorded, domain, request):
    rule, rest = rule_of(block)
    if rule == "together":
        lines = lines_of(block)
        with processes(lines, recorded, domain) as running:
            if rest == "until active":
                wait_until_active([name_of(line) for line in lines], domain.domain)
            else:
                wait_until_printed(rest.removeprefix("until ").split(", "), running)
    elif rule == "beside":
        run(block.body, recorded, request.getfixturevalue("rig"))
    elif block.body.strip() != DEMO:  # run by the fixture `recorded`
        assert rule in ("", "with", "data"), block.rule
        if rule == "data":
            write_recording(recorded / rest)
        run(block.body.strip() + (f" {rest}" if rule == "with" else ""), recorded, domain)
