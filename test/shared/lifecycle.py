# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Observe nodes of other processes: wait for conditions, and for lifecycle nodes to be active."""

import contextlib
import time

import rclpy
from lifecycle_msgs.msg import State
from lifecycle_msgs.srv import GetState
from rclpy.executors import SingleThreadedExecutor

TIMEOUT_S = 90.0
RETRY_S = 3.0  # without a response after which a request is repeated


@contextlib.contextmanager
def observer(domain):
    """A node in a ROS domain, and `until(condition, text)`, which serves it until a condition is true."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain)
    node = rclpy.create_node("observer", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)

    def until(condition, text=lambda: "timeout"):
        end = time.monotonic() + TIMEOUT_S
        while not condition():
            assert time.monotonic() < end, text()
            executor.spin_once(timeout_sec=0.05)

    try:
        yield node, until
    finally:
        node.destroy_node()
        rclpy.shutdown(context=context)


def wait_until_active(domain, *names, alive=lambda: True):
    """Wait until all nodes of a ROS domain (fully qualified names) are active; fail once `alive` is false."""
    with observer(domain) as (node, until):
        waiting = {name: node.create_client(GetState, f"{name}/get_state") for name in names}
        requests = {}

        def all_active():
            assert alive(), "a process has ended"
            for name, client in list(waiting.items()):
                future, since = requests.get(name, (None, 0.0))
                if future is not None and future.done():
                    del requests[name]
                    if future.result().current_state.id == State.PRIMARY_STATE_ACTIVE:
                        del waiting[name]
                elif client.service_is_ready() and time.monotonic() - since > RETRY_S:
                    requests[name] = client.call_async(GetState.Request()), time.monotonic()
            return not waiting

        until(all_active, lambda: f"not active: {', '.join(waiting)}")
