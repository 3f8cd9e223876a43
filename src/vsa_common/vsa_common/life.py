"""A process of the suite: its nodes come up, live until a signal, and go down in order."""

import gc
import inspect
import os
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import rclpy
from rclpy.executors import Executor
from rclpy.experimental import EventsExecutor
from rclpy.signals import SignalHandlerOptions
from vsa_common.configuration import ConfigurationError, parameter_files, read_parameter_file
from vsa_common.node import RCLError, SuiteNode
from vsa_common.realtime import ask_for, compute_alone, wake_on_time


def run(
    create: Callable[[], SuiteNode[Any] | Sequence[SuiteNode[Any]]],
    args: list[str] | None = None,
    executor: Callable[[], Executor] = EventsExecutor,
    turn: Callable[[Executor, Sequence[SuiteNode[Any]]], None] = lambda executor, _: executor.spin_once(1.0),
) -> int:
    """Live as one node, or several, until SIGINT or SIGTERM; exit code 0 then, 1 with one line where one cannot start.

    Several start in their order and stop in the other one. The signals only end the loop of turns: a node still has its
    topics while it stops.
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
        wake_on_time()
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
        spinner = executor()
        speaker = ""  # a node that cannot be names itself
        created = create()
        nodes = [created] if isinstance(created, SuiteNode) else created
        for node in nodes:
            speaker = f"{node.get_name()}: "
            spinner.add_node(node)
            node.autostart()
            for refusal in ask_for(node.common.realtime):
                node.get_logger().warning(refusal)
        compute_alone()
        inspect.getframeinfo(sys._getframe())  # walks all modules once; else the first warning would, for 70 ms
        gc.freeze()  # what is there now stays; the collector need not walk through it again
        while not stopped:
            turn(spinner, nodes)
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
    """Let Fast DDS, where it is the middleware, publish at half the cost; before `rclpy.init`. Your own file wins."""
    os.environ.setdefault("FASTRTPS_DEFAULT_PROFILES_FILE", str(Path(__file__).parent / "fastdds.xml"))


def check_parameter_files(arguments: Sequence[str]) -> None:
    """Raise ConfigurationError for a `--params-file` that cannot be read; rcl would name a line of its parser."""
    for path in parameter_files(arguments):
        read_parameter_file(path)
