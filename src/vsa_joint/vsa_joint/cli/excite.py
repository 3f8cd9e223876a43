# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Move the motors until the wanted quantities of both transmissions are known: the client of the action Excite.

The node `vsa_joint excitation` chooses the motion and commands the motors; estimators and driver run, and the driver
is armed (`python examples/call.py driver/arm true`). The joint is free and pretensioned: the motion is a co-contraction
of a few millimetres about the present positions, in which the joint turns little. It is the D-optimal one of a family
of multisines for the wanted quantities at the present estimate.

Ctrl-C cancels; the motors then keep their positions. The table has the value of each quantity, half of its 95 %
interval, and the time after which it was known.
"""

import argparse
import contextlib
import signal
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

import rclpy
from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.experimental import EventsExecutor
from rclpy.signals import SignalHandlerOptions
from vsa_common.ros.process import ignore_signals, tune_middleware
from vsa_common.terminal import Bar, progress, show_table
from vsa_joint.excitation.quantities import DEFAULT, INTERVAL, UNITS
from vsa_msgs.action import Excite
from vsa_msgs.msg import QuantityEstimate

CONNECT_S = 10.0  # [s] for the node to be found
ANSWER_S = 5.0  # [s] for an answer, or without feedback
NOT_KNOWN, INTERRUPTED = 1, 130  # exit codes


class ExciteError(RuntimeError):
    """The node does not answer."""


class Client:
    """Sends one goal and waits for its result."""

    def __init__(self, namespace: str) -> None:
        tune_middleware()
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        self._node = rclpy.create_node("excite", namespace=namespace)
        self._executor = EventsExecutor()
        self._executor.add_node(self._node)
        self._client = ActionClient(self._node, Excite, "excitation/excite")
        self._answer: Any = None  # future of the goal's handle, from the sending on
        self._result: Any = None  # future
        self.feedback: Excite.Feedback | None = None
        self._feedback_s = 0.0

    def send(self, goal: Excite.Goal) -> None:
        """Send a goal. Raises ExciteError where the node is absent or does not accept it."""
        name = f"{self._node.get_namespace()}/excitation"
        start = f"no node {name}; start it: ./vsa run vsa_joint excitation --ros-args --params-file my_rig.yaml"
        self._wait(self._client.server_is_ready, CONNECT_S, start)
        self._answer = self._client.send_goal_async(goal, feedback_callback=self._on_feedback)
        self._wait(self._answer.done, ANSWER_S, f"{name} does not answer")
        if not self._answer.result().accepted:
            raise ExciteError(f"{name} does not accept the goal")

    def result(self, update: Callable[[], None]) -> Any:
        """The result of the accepted goal with its status; `update` is called while waiting. Raises ExciteError."""
        if self._result is None:
            self._result = self._answer.result().get_result_async()
        self._feedback_s = time.monotonic()
        while not self._result.done():
            self._executor.spin_once(timeout_sec=0.1)
            update()
            if time.monotonic() - self._feedback_s > ANSWER_S:
                raise ExciteError(f"no feedback for {ANSWER_S:.0f} s")
        return self._result.result()

    def cancel(self) -> bool:
        """Cancel the goal that was sent, also one whose acceptance is still to come; whether a goal was accepted.

        Waits for at most ANSWER_S for the acceptance, and as long for the answer to the cancellation.
        """
        if self._answer is None:
            return False
        with contextlib.suppress(ExciteError):
            self._wait(self._answer.done, ANSWER_S, "no acceptance")
            handle = self._answer.result()
            if not handle.accepted:
                return False
            self._wait(handle.cancel_goal_async().done, ANSWER_S, "no answer to the cancellation")
        return bool(self._answer.done())

    def close(self) -> None:
        """Leave the ROS graph."""
        self._client.destroy()
        self._node.destroy_node()
        rclpy.try_shutdown()

    def _on_feedback(self, message: Any) -> None:
        self.feedback, self._feedback_s = message.feedback, time.monotonic()

    def _wait(self, condition: Callable[[], bool], limit: float, text: str) -> None:
        end = time.monotonic() + limit
        while not condition():
            if time.monotonic() > end:
                raise ExciteError(text)
            self._executor.spin_once(timeout_sec=0.1)


def main(args: Sequence[str] | None = None) -> int:
    """Entry point."""
    options = _parser().parse_args(args)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    client = Client(options.namespace)
    try:
        answer = _run(client, options)
    except ExciteError as error:
        print(f"excite: {error}", file=sys.stderr)
        return NOT_KNOWN
    except KeyboardInterrupt:  # before a goal was accepted
        return INTERRUPTED
    finally:
        client.close()
    if answer.result.quantities:
        show_table("Excitation", _HEADER, [_row(one) for one in answer.result.quantities], texts=2)
    print(f"excite: {answer.result.message}", file=sys.stdout if answer.result.success else sys.stderr)
    if answer.status == GoalStatus.STATUS_CANCELED:
        return INTERRUPTED
    return 0 if answer.result.success else NOT_KNOWN


def _run(client: Client, options: argparse.Namespace) -> Any:
    """Send the goal and show its progress; an interrupt or a silent node cancels it."""
    goal = Excite.Goal(
        quantities=options.quantity or list(DEFAULT),
        relative_interval=options.interval / 100.0,
        duration=options.duration,
        travel=options.travel,
        speed=options.speed,
        tension=options.tension,
    )
    try:
        client.send(goal)
        with progress(None, "motors at rest") as bar:
            return client.result(lambda: _show(bar, client.feedback))
    except KeyboardInterrupt:
        ignore_signals()
        if not client.cancel():
            raise
        return client.result(lambda: None)
    except ExciteError:
        client.cancel()
        raise


def _show(bar: Bar, feedback: Excite.Feedback | None) -> None:
    if feedback is None:
        return
    known = sum(one.known for one in feedback.quantities)
    widest = max(feedback.quantities, key=_relative_interval, default=None)
    text = f"{feedback.elapsed:.0f} s, at most {feedback.remaining:.0f} s more; {feedback.motion}; "
    text += f"{known} of {len(feedback.quantities)} known"
    if widest is not None:
        text += f", widest: {widest.quantity} of {widest.transmission} +- {100.0 * _relative_interval(widest):.1f} %"
    bar.advance(0.0, text)


_HEADER = ("transmission", "quantity", "value", "95 % interval, +-", "unit", "+-, %", "known after, s")


def _row(one: QuantityEstimate) -> list[str]:
    half = INTERVAL * one.standard_deviation
    known = f"{one.known_after:.1f}" if one.known else "not known"
    percent = f"{100.0 * _relative_interval(one):.2g}"
    return [one.transmission, one.quantity, f"{one.value:.5g}", f"{half:.2g}", one.unit, percent, known]


def _relative_interval(one: QuantityEstimate) -> float:
    return INTERVAL * one.standard_deviation / max(abs(one.value), 1e-300)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="excite",
        description=__doc__,
        epilog="Exit code 0: every wanted quantity is known; 1: one is not, or the goal is refused; 130: canceled. "
        "An option that is absent, or 0, has the value of the node's parameter; no option exceeds the parameters.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    names = ", ".join(DEFAULT)
    add("--quantity", nargs="+", choices=UNITS, metavar="NAME", help=f"of {', '.join(UNITS)} (default: {names})")
    add("--interval", type=float, default=0.0, metavar="PERCENT",
        help="wanted half of the 95 %% interval; without it validity suffices (docs/reference/faults.md)")  # fmt: skip
    add("--duration", type=float, default=0.0, metavar="S", help="greatest duration (60 s)")
    add("--travel", type=float, default=0.0, metavar="M", help="greatest change of the mean deflection (0.0035 m)")
    add("--speed", type=float, default=0.0, metavar="M/S", help="greatest speed of the mean deflection (0.005 m/s)")
    add("--tension", type=float, default=0.0, metavar="N", help="greatest tendon tension (half of force_max: 95 N)")
    add("--namespace", default="vsa", metavar="NS", help="namespace of the joint (%(default)s)")
    return parser


if __name__ == "__main__":
    sys.exit(main())
