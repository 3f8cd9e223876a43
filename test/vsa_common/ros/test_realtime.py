# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Real-time hints, each in a process and session of its own, as they last until its end."""

import subprocess
import sys
from pathlib import Path

import pytest

IMPORTS = "from vsa_common.ros.realtime import RealTime, apply_hints; import os, threading; "
AUTOGROUP = Path("/proc/self/autogroup")
THREAD = "threading.Thread(target=threading.Event().wait, daemon=True).start(); "


def output_of(code):
    command = [sys.executable, "-c", IMPORTS + code]
    run = subprocess.run(command, capture_output=True, text=True, check=True, start_new_session=True)
    return run.stdout.strip()


def test_default_hints_change_nothing():
    before = output_of("print(os.sched_getscheduler(0), os.nice(0))")
    assert output_of("print(*apply_hints(RealTime()), os.sched_getscheduler(0), os.nice(0))") == before


def test_a_nice_value_holds_for_every_thread():
    code = "apply_hints(RealTime(nice=19)); threads = map(int, os.listdir('/proc/self/task')); "
    assert output_of(THREAD + code + "print(*[os.getpriority(os.PRIO_PROCESS, t) for t in threads])") == "19 19"


@pytest.mark.skipif(not AUTOGROUP.exists(), reason="the kernel has no autogroups")
def test_a_nice_value_holds_for_the_session():
    assert output_of(f"apply_hints(RealTime(nice=3)); print(open('{AUTOGROUP}').read())").endswith(" nice 3")


def test_cores_hold_for_every_thread():
    code = "core = max(os.sched_getaffinity(0)); print(*apply_hints(RealTime(cores=str(core)))); "
    code += "print([os.sched_getaffinity(int(t)) for t in os.listdir('/proc/self/task')] == 2 * [{core}])"
    assert output_of(THREAD + code) == "True"


def test_cores_that_do_not_exist_are_reported_and_change_nothing():
    code = "before = os.sched_getaffinity(0); "
    code += "print(*apply_hints(RealTime(cores='700')), *apply_hints(RealTime(cores='one')), sep='\\n'); "
    lines = output_of(code + "print(os.sched_getaffinity(0) == before)").splitlines()
    assert [line.split("(")[0] for line in lines] == [
        "realtime.cores = '700' is not permitted ", "realtime.cores = 'one' is not permitted ", "True"
    ]  # fmt: skip


def test_temporary_hints_are_undone_at_the_end_of_the_block():
    code = "from vsa_common.ros.realtime import temporarily_applied; state = lambda: [(os.sched_getaffinity(int(t)), "
    code += "os.sched_getscheduler(int(t))) for t in os.listdir('/proc/self/task')]; before = state(); "
    code += "core = max(os.sched_getaffinity(0))\n"
    code += "with temporarily_applied(RealTime(cores=str(core), priority=1)) as refused: during = state()\n"
    code += "print({cores == {core} for cores, _ in during}, len(refused) or {kind for _, kind in during}, "
    code += "state() == before, len(before))"
    assert output_of(THREAD + code) in ("{True} {1} True 2", "{True} 1 True 2")  # FIFO, or refused


def test_timer_slack_holds_in_threads_started_later():
    code = "import ctypes; from vsa_common.ros.realtime import set_timer_slack; libc = ctypes.CDLL(None); "
    code += "slack = lambda: libc.prctl(30, 0, 0, 0, 0); before = slack(); set_timer_slack(); "
    code += "thread = threading.Thread(target=lambda: print(before > 1, slack())); thread.start(); thread.join()"
    assert output_of(code) == "True 1"


def test_a_refused_hint_is_reported_with_its_remedy_and_does_not_end_the_process():
    limits = "RLIMIT_RTPRIO", "RLIMIT_NICE", "RLIMIT_MEMLOCK"
    drop = f"import resource; [resource.setrlimit(getattr(resource, one), (0, 0)) for one in {limits}]; "
    drop += "os.geteuid() or (os.setgid(65534), os.setuid(65534)); "
    lines = output_of(drop + "print(*apply_hints(RealTime(priority=50, nice=-5, lock_memory=True)), sep='\\n')")
    assert "realtime.nice = -5 is not permitted" in lines
    assert "realtime.priority = 50 is not permitted" in lines
    assert "LimitRTPRIO=" in lines
