# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The client of the action Excite with a stand-in for the node: an interrupt or a silence leaves no goal in work."""

import time
from types import SimpleNamespace

import pytest
from action_msgs.msg import GoalStatus
from rclpy.task import Future
from vsa_joint.cli import excite
from vsa_msgs.action import Excite


class Server:
    """Answers after a number of turns of the executor; `interrupted_at` is the turn with Ctrl-C.

    A goal without cancellation has no result.
    """

    def __init__(self, accepted_at=3, accepted=True, interrupted_at=None, turn_s=0.0):
        self.turn, self.accepted_at, self.accepted, self.interrupted_at = 0, accepted_at, accepted, interrupted_at
        self.turn_s, self.canceled = turn_s, False
        self.answer, self.result = Future(), Future()

    def server_is_ready(self):
        return True

    def send_goal_async(self, goal, feedback_callback):
        return self.answer

    def get_result_async(self):
        return self.result

    def cancel_goal_async(self):
        self.canceled = True
        self.result.set_result(
            SimpleNamespace(status=GoalStatus.STATUS_CANCELED, result=Excite.Result(message="canceled"))
        )
        done = Future()
        done.set_result(None)
        return done

    def spin_once(self, timeout_sec):
        self.turn += 1
        time.sleep(self.turn_s)
        if self.turn == self.accepted_at:
            self.answer.set_result(self)
        if self.turn == self.interrupted_at:
            raise KeyboardInterrupt

    def add_node(self, node):
        pass

    def destroy(self):
        pass


@pytest.fixture
def run(monkeypatch):
    def run_with(server):
        node = SimpleNamespace(get_namespace=lambda: "/vsa", destroy_node=lambda: None)
        fake = SimpleNamespace(init=lambda **_: None, create_node=lambda *_, **__: node, try_shutdown=lambda: None)
        monkeypatch.setattr(excite, "rclpy", fake)
        monkeypatch.setattr(excite, "EventsExecutor", lambda: server)
        monkeypatch.setattr(excite, "ActionClient", lambda *_: server)
        for name in ("tune_middleware", "ignore_signals"):
            monkeypatch.setattr(excite, name, lambda: None)
        monkeypatch.setattr(excite.signal, "signal", lambda *_: None)
        monkeypatch.setattr(excite, "ANSWER_S", 0.2)
        return excite.main([])

    return run_with


@pytest.mark.parametrize("turn", [1, 2, 3, 4, 20])
def test_an_interrupt_before_or_after_the_acceptance_cancels_the_goal(run, turn, capsys):
    server = Server(accepted_at=3, interrupted_at=turn)
    assert run(server) == excite.INTERRUPTED
    assert server.canceled
    assert "canceled" in capsys.readouterr().err


def test_a_node_without_feedback_gets_a_cancellation(run, capsys):
    server = Server()
    assert run(server) == excite.NOT_KNOWN
    assert server.canceled
    assert "no feedback for" in capsys.readouterr().err


def test_a_goal_that_is_accepted_after_the_limit_is_canceled(run, capsys):
    server = Server(accepted_at=3, turn_s=0.15)
    assert run(server) == excite.NOT_KNOWN
    assert server.canceled
    assert "does not answer" in capsys.readouterr().err


def test_an_interrupt_of_a_refused_or_unanswered_goal_ends_within_the_limit(run):
    refused = Server(accepted=False, interrupted_at=1)
    assert run(refused) == excite.INTERRUPTED
    assert run(Server(accepted_at=None, interrupted_at=1)) == excite.INTERRUPTED
    assert not refused.canceled
