# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`./vsa bench live` and `./vsa bench view`: counts, delays and processor time."""

import json
import os
import subprocess

import numpy as np
import pytest
from vsa_bench.harness.deployment import Case
from vsa_bench.harness.run import figures, run_case
from vsa_bench.harness.score import JointRecord, quantiles, score
from vsa_bench.live.report import HEADER, row
from vsa_bench.view import command as bench_view
from vsa_common.ros.subprocesses import executable

pytestmark = pytest.mark.live

RUN = {
    "mode", "rate_hz", "joints", "duration_s", "samples_sent", "samples_fused", "samples_lost", "sustained",
    "latency_ms", "machine_late_ms", "stolen_percent", "cpu_percent", "rss_growth_mb",
}  # fmt: skip
MS = 1_000_000


def joint_record(delays_ms, sent=None, pair=lambda k: k):
    """One joint at 1 kHz; `pair` gives the sample of side 2 in the message of sample k."""
    first = {1_000 * MS + k * MS: k for k in range(len(delays_ms))}
    second = {stamp_ns + 20_000: k for stamp_ns, k in first.items()}
    stamps = list(second)
    rows = [
        (at, stamps[pair(k)], stamps[k] + round(delay * MS))
        for (at, k), delay in zip(first.items(), delays_ms, strict=True)
        if delay is not None
    ]
    return JointRecord(len(delays_ms) if sent is None else sent, np.array(rows, np.int64), first, second)


def test_delays_count_from_the_later_frame_of_a_sample():
    result = score([joint_record([float(k) / 10.0 for k in range(11)])])
    assert result.latency_ms == {"p50": 0.5, "p99": 0.99, "p999": 0.999, "max": 1.0}
    assert (result.sent, result.fused, result.lost, result.sustained) == (11, 11, 0, True)


def test_a_sample_without_a_message_is_lost():
    result = score([joint_record([0.5, None, 0.5, 0.5]), joint_record([0.5] * 4, sent=6)])
    assert (result.sent, result.fused, result.lost, result.sustained) == (10, 7, 3, False)


def test_a_message_with_sides_of_different_samples_counts_no_sample():
    result = score([joint_record([0.5] * 10, pair=lambda k: max(k - 1, 0))])
    assert result.fused == 1


def test_a_growing_delay_is_not_sustained():
    assert not score([joint_record(np.linspace(0.5, 50.0, 100).tolist())]).sustained


def test_a_run_without_messages_is_not_sustained():
    result = score([JointRecord(10, np.empty((0, 3), np.int64), {}, {})])
    assert (result.lost, result.sustained, result.latency_ms["p99"]) == (10, False, None)
    run = figures(Case("composed", 1000, 1, 1.0), result, {"composed": 50.0}, 0.0)
    run |= {"machine_late_ms": quantiles(np.empty(0)), "stolen_percent": 0.0}
    assert row(run)[-1] == "not sustained"
    assert len(row(run)) == len(HEADER)


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bench")
    command = [executable("vsa_bench", "bench"), "live", "--rate", "50", "--duration", "2"]
    command += ["--mode", "composed", "--joints", "1", "2"]
    command += ["--json", str(folder / "live.json"), "--plot", str(folder / "live.png")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert (folder / "live.png").stat().st_size > 10_000
    assert "not sustained" not in done.stdout
    return json.loads((folder / "live.json").read_text())["runs"]


def test_a_run_has_the_documented_form(runs):
    assert all(set(run) == RUN for run in runs)
    assert [run["joints"] for run in runs] == [1, 2]
    assert set(runs[0]["cpu_percent"]) == {"rig_simulator", "composed", "subscriber"}
    assert all(0.0 < percent < 400.0 for run in runs for percent in run["cpu_percent"].values())


def test_a_run_has_the_wake_up_latency_of_the_machine(runs):
    assert all(0.0 <= run["stolen_percent"] < 100.0 * os.cpu_count() for run in runs)
    for late in (run["machine_late_ms"] for run in runs):
        assert 0.0 < late["p50"] <= late["p99"] <= late["max"]


def test_every_sample_of_every_joint_arrives(runs):
    assert [run["samples_sent"] for run in runs] == [100, 200]
    assert all(run["samples_lost"] == 0 for run in runs)
    assert all(0.05 < run["latency_ms"]["p50"] <= run["latency_ms"]["p99"] <= run["latency_ms"]["max"] for run in runs)


def test_the_server_of_the_page_is_measured_beside_the_nodes(tmp_path):
    case = Case("composed", 50, 1, 2.0)
    start = bench_view.companions(case, tmp_path)[bench_view.ELSEWHERE]
    run = run_case(case, tmp_path, start)
    assert set(run) == RUN
    assert (run["samples_sent"], run["samples_lost"]) == (100, 0)
    assert set(run["cpu_percent"]) == {"rig_simulator", "composed", "subscriber", "view"}
    assert 0.0 < run["cpu_percent"]["view"] < 400.0


def test_the_cost_of_the_page_is_separate_from_that_of_the_nodes():
    def run(view, suite, p99, lost):
        delays = {"p50": 0.5, "p99": p99, "p999": 3.0, "max": 4.0}
        cpu = {"rig_simulator": 90.0, "subscriber": 80.0, "driver": 10.0, "joint": suite - 10.0} | view
        return {"cpu_percent": cpu, "latency_ms": delays, "samples_sent": 100, "samples_lost": lost}

    runs = [run({"view": 8.0}, 50.0, 1.0, 0), run({"view": 9.0}, 60.0, 2.0, 1), run({"view": 7.0}, 70.0, 9.0, 0)]
    page = bench_view.ELSEWHERE
    assert bench_view.row(page, runs) == [page, "8.0", "60", "300", "1", "0.50", "2.00", "3.00", "4.00"]
    assert bench_view.row(bench_view.NONE, [run({}, 50.0, None, 100)])[1:6] == ["-", "50", "100", "100", "0.50"]
