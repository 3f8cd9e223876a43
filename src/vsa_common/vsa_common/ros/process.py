"""A process of the suite: its nodes come up, live until a signal, and go down in order."""

import gc
import inspect
import os
import signal
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import rclpy
from rclpy.executors import Executor
from rclpy.experimental import EventsExecutor
from rclpy.signals import SignalHandlerOptions
from vsa_common.config.configuration import ConfigurationError, parameter_files, read_parameter_file
from vsa_common.ros.idle import Coalescer
from vsa_common.ros.node import RCLError, SuiteNode
from vsa_common.ros.realtime import apply_hints, limit_blas_threads, set_timer_slack

WAIT_S = 1.0  # for something to do, at most, before signals are looked for


class Spinner:
    """Whatever comes, one thing at a time while there is little, and all that has gathered during a rest otherwise.

    Rests need an executor that serves in the order of arrival, as EventsExecutor does.
    """

    def __init__(self, rest_s: float) -> None:
        self._rest = Coalescer(rest_s)

    def __call__(self, executor: Executor, _: Sequence[SuiteNode[Any]], wait_s: float) -> None:
        """One turn."""
        executor.spin_once(wait_s)
        rest = self._rest.due()
        if rest > 0.0:
            done: list[bool] = []
            executor.create_task(done.append, True)  # comes after all that waits by now
            while not done:
                executor.spin_once(0.0)
            time.sleep(rest)


def run(
    create: Callable[[], SuiteNode[Any] | Sequence[SuiteNode[Any]]],
    args: list[str] | None = None,
    executor: Callable[[], Executor] = EventsExecutor,
    turn: Callable[[float], Callable[[Executor, Sequence[SuiteNode[Any]], float], None]] = Spinner,
) -> int:
    """Live as one node, or several, until SIGINT or SIGTERM; exit code 0 then, 1 with one line if one cannot start.

    Several start in their order and stop in the other one. `turn` is made of the rest [s] that the nodes ask for. The
    signals only end the loop of its turns, each of which may sleep for the seconds that it is given: a node still has
    its topics while it stops.
    """
    nodes: Sequence[SuiteNode[Any]] = []
    stopped = False

    def on_signal(*_: object) -> None:
        nonlocal stopped
        stopped = True

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, on_signal)
    speaker = f"{Path(sys.argv[0]).name}: "
    try:
        check_parameter_files(sys.argv if args is None else args)
        tune_middleware()
        set_timer_slack()
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
        spinner = executor()
        speaker = ""  # a node that cannot be names itself
        created = create()
        nodes = [created] if isinstance(created, SuiteNode) else created
        for node in nodes:
            speaker = f"{node.get_name()}: "
            spinner.add_node(node)
            node.autostart()
            for refusal in apply_hints(node.common.realtime):
                node.get_logger().warning(refusal)
        limit_blas_threads()
        inspect.getframeinfo(sys._getframe())  # walks all modules once; else the first warning would, for 70 ms
        gc.freeze()  # what is there now stays; the collector need not walk through it again
        hints = [node.common.realtime for node in nodes]
        busy = any(hint.busy for hint in hints)
        wait = 0.0 if busy else WAIT_S
        serve = turn(0.0 if busy else max(hint.rest for hint in hints))
        while not stopped:
            serve(spinner, nodes, wait)
        return 0
    except (ConfigurationError, OSError, RCLError) as error:
        print(f"{speaker}{' '.join(str(error).split())}", file=sys.stderr)
        return 1
    finally:
        for node in reversed(nodes):
            node.close()
        for node in reversed(nodes):
            node.destroy_node()
        rclpy.try_shutdown()
        gc.unfreeze()  # or the participant, in cycles, outlives Python, and may wait for ever for a thread of its


def tune_middleware() -> None:
    """Let Fast DDS publish at half the cost, and without shared memory; before `rclpy.init`. Your own file wins.

    For the range LOCALHOST rmw_fastrtps insists on shared memory: there a file says the same of whom to hear.
    """
    if "FASTRTPS_DEFAULT_PROFILES_FILE" in os.environ:
        return
    local = os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE") == "LOCALHOST" and not os.environ.get("ROS_STATIC_PEERS")
    if local:
        os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "SYSTEM_DEFAULT"
    profiles = Path(__file__).parent / ("fastdds_localhost.xml" if local else "fastdds.xml")
    os.environ["FASTRTPS_DEFAULT_PROFILES_FILE"] = str(profiles)


def check_parameter_files(arguments: Sequence[str]) -> None:
    """Raise ConfigurationError for a `--params-file` that cannot be read; rcl would name a line of its parser."""
    for path in parameter_files(arguments):
        read_parameter_file(path)
