# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""A process of the suite: it starts its nodes, serves them until a signal, and stops them in reverse order."""

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
from vsa_common.blas import limit_blas_threads
from vsa_common.config.configuration import ConfigurationError
from vsa_common.config.sections import files_without
from vsa_common.ros.arguments import check_arguments, check_parameter_files
from vsa_common.ros.idle import Coalescer
from vsa_common.ros.node import RCLError, StartRefused, SuiteNode
from vsa_common.ros.realtime import apply_hints, set_timer_slack

WAIT_S = 1.0  # an idle turn ends after this time, so that a signal is noticed

Nodes = Sequence[SuiteNode[Any]]
Turn = Callable[[Executor, Nodes, float], None]  # waits at most so long [s]


class Spinner:
    """Turns of an executor: one callback at a time under a low load, all that have gathered during a pause otherwise.

    Pauses need an executor that serves callbacks in the order of arrival, as EventsExecutor does.
    """

    def __init__(self, pause_s: float) -> None:
        self._coalescer = Coalescer(pause_s)

    def __call__(self, executor: Executor, _: Nodes, wait_s: float) -> None:
        """One turn; waits at most `wait_s` [s]."""
        executor.spin_once(wait_s)
        pause = self._coalescer.pause()
        if pause > 0.0:
            done: list[bool] = []
            executor.create_task(done.append, True)  # runs after all callbacks that are queued at this point
            while not done:
                executor.spin_once(0.0)
            time.sleep(pause)


def run(
    create: Callable[[], SuiteNode[Any] | Nodes],
    args: list[str] | None = None,
    executor: Callable[[], Executor] = EventsExecutor,
    turn: Callable[[float], Turn] = Spinner,
    description: str = "",
) -> int:
    """Run one node, or several, until SIGINT or SIGTERM; exit code 0 then, 1 with one line if one cannot start.

    Several nodes stop in the reverse order. `turn` is called with the pause [s] that the nodes request. A signal only
    ends the loop of turns: a node has its topics while it stops. `description`, or the docstring of `create`, is the
    text of `--help`.
    """
    arguments = sys.argv if args is None else args
    nodes: Nodes = []
    signals = _received_signals()
    name = f"{Path(sys.argv[0]).name}: "
    try:
        check_arguments(arguments, description or inspect.getdoc(create) or "")
        _initialize(arguments)
        spinner = executor()
        name = ""  # errors of the nodes' constructors contain the node's name
        nodes = _as_list(create())
        for node in nodes:
            name = f"{node.get_name()}: "
            spinner.add_node(node)
            _start(node, arguments)
        _end_startup()
        pause, wait = _pause_and_wait(nodes)
        serve = turn(pause)
        while not signals:
            serve(spinner, nodes, wait)
        return 0
    except StartRefused:  # in the node's log
        return 1
    except (ConfigurationError, OSError, RCLError) as error:
        print(f"{name}{' '.join(str(error).split())}", file=sys.stderr)
        return 1
    finally:
        _shut_down(nodes)


def _as_list(created: SuiteNode[Any] | Nodes) -> Nodes:
    return [created] if isinstance(created, SuiteNode) else created


def _pause_and_wait(nodes: Nodes) -> tuple[float, float]:
    """Pause between two turns and longest wait of an idle turn [s], as the nodes request; both 0 for a busy node."""
    hints = [node.common.realtime for node in nodes]
    return (0.0, 0.0) if any(hint.busy for hint in hints) else (max(hint.rest for hint in hints), WAIT_S)


def _received_signals() -> list[int]:
    """A list to which SIGINT and SIGTERM are appended as they arrive."""
    signals: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda received, _: signals.append(received))
    return signals


def _initialize(arguments: list[str]) -> None:
    check_parameter_files(arguments)
    tune_middleware()
    set_timer_slack()
    rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)


def _start(node: SuiteNode[Any], arguments: Sequence[str]) -> None:
    """Start a node; warn if no parameter file has a section for it, as with another namespace or a misspelt name."""
    name = node.get_fully_qualified_name()
    if files := files_without(arguments, name):
        node.get_logger().warning(f"{', '.join(files)}: nothing for {name}; its parameters have their defaults")
    node.autostart()
    for refusal in apply_hints(node.common.realtime):
        node.get_logger().warning(refusal)


def _end_startup() -> None:
    limit_blas_threads()
    inspect.getframeinfo(sys._getframe())  # fills the cache of modules that the first warning needs, for 70 ms
    gc.freeze()  # objects of the start are permanent; the collector skips them


def _shut_down(nodes: Nodes) -> None:
    for node in reversed(nodes):
        node.close()
    for node in reversed(nodes):
        node.destroy_node()
    rclpy.try_shutdown()
    ignore_signals()
    gc.unfreeze()  # a participant in a reference cycle that outlives Python can block on one of its threads


def ignore_signals() -> None:
    """Ignore SIGINT and SIGTERM until the process has ended: a second one would end it with another exit code."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)


def tune_middleware() -> None:
    """Set the Fast DDS profile of the suite: half the cost of publishing, no shared memory. Call before `rclpy.init`.

    A profile that the user has set takes precedence. rmw_fastrtps forces shared memory in the discovery range
    LOCALHOST; there the profile itself restricts the discovery.
    """
    if "FASTRTPS_DEFAULT_PROFILES_FILE" in os.environ:
        return
    local = os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE") == "LOCALHOST" and not os.environ.get("ROS_STATIC_PEERS")
    if local:
        os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "SYSTEM_DEFAULT"
    profiles = Path(__file__).parent / ("fastdds_localhost.xml" if local else "fastdds.xml")
    os.environ["FASTRTPS_DEFAULT_PROFILES_FILE"] = str(profiles)
