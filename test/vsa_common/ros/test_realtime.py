"""Wishes to the kernel, in a process of their own: they outlive the one who asks."""

import subprocess
import sys

ASK = "from vsa_common.ros.realtime import RealTime, apply_hints; import os, threading; "
THREAD = "threading.Thread(target=threading.Event().wait, daemon=True).start(); "


def answer(code):
    run = subprocess.run([sys.executable, "-c", ASK + code], capture_output=True, text=True, check=True)
    return run.stdout.strip()


def test_no_wish_changes_nothing():
    before = answer("print(os.sched_getscheduler(0), os.nice(0))")
    assert answer("print(*apply_hints(RealTime()), os.sched_getscheduler(0), os.nice(0))") == before


def test_a_nice_value_holds_for_every_thread():
    code = "apply_hints(RealTime(nice=19)); threads = map(int, os.listdir('/proc/self/task')); "
    assert answer(THREAD + code + "print(*[os.getpriority(os.PRIO_PROCESS, t) for t in threads])") == "19 19"


def test_cores_hold_for_every_thread():
    code = "core = max(os.sched_getaffinity(0)); print(*apply_hints(RealTime(cores=str(core)))); "
    code += "print([os.sched_getaffinity(int(t)) for t in os.listdir('/proc/self/task')] == 2 * [{core}])"
    assert answer(THREAD + code) == "True"


def test_cores_that_are_not_there_are_said_and_change_nothing():
    code = "before = os.sched_getaffinity(0); "
    code += "print(*apply_hints(RealTime(cores='700')), *apply_hints(RealTime(cores='one')), sep='\\n'); "
    said = answer(code + "print(os.sched_getaffinity(0) == before)").splitlines()
    assert [line.split("(")[0] for line in said] == [
        "realtime.cores = '700' is not permitted ", "realtime.cores = 'one' is not permitted ", "True"
    ]  # fmt: skip


def test_temporarily_applied_is_temporarily_applied():
    code = "from vsa_common.ros.realtime import temporarily_applied; look = lambda: [(os.sched_getaffinity(int(t)), "
    code += "os.sched_getscheduler(int(t))) for t in os.listdir('/proc/self/task')]; before = look(); "
    code += "core = max(os.sched_getaffinity(0))\n"
    code += "with temporarily_applied(RealTime(cores=str(core), priority=1)) as refused: during = look()\n"
    code += "print({cores == {core} for cores, _ in during}, len(refused) or {kind for _, kind in during}, "
    code += "look() == before, len(before))"
    assert answer(THREAD + code) in ("{True} {1} True 2", "{True} 1 True 2")  # FIFO, or refused


def test_a_wait_ends_when_it_should_in_threads_started_later_too():
    code = "import ctypes; from vsa_common.ros.realtime import set_timer_slack; libc = ctypes.CDLL(None); "
    code += "slack = lambda: libc.prctl(30, 0, 0, 0, 0); before = slack(); set_timer_slack(); "
    code += "thread = threading.Thread(target=lambda: print(before > 1, slack())); thread.start(); thread.join()"
    assert answer(code) == "True 1"


def test_linear_algebra_is_done_by_the_thread_that_asks_for_it():
    code = "import numpy, scipy.linalg, threadpoolctl; "
    code += "from vsa_common.ros.realtime import limit_blas_threads; limit_blas_threads(); "
    run = subprocess.run(
        [sys.executable, "-c", code + "print({i['num_threads'] for i in threadpoolctl.threadpool_info()})"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert run.stdout.strip() == "{1}"


def test_what_is_not_permitted_is_said_with_its_remedy_and_does_not_end_the_process():
    limits = "RLIMIT_RTPRIO", "RLIMIT_NICE", "RLIMIT_MEMLOCK"
    drop = f"import resource; [resource.setrlimit(getattr(resource, one), (0, 0)) for one in {limits}]; "
    drop += "os.geteuid() or (os.setgid(65534), os.setuid(65534)); "
    said = answer(drop + "print(*apply_hints(RealTime(priority=50, nice=-5, lock_memory=True)), sep='\\n')")
    assert "realtime.nice = -5 is not permitted" in said
    assert "realtime.priority = 50 is not permitted" in said
    assert "LimitRTPRIO=" in said
