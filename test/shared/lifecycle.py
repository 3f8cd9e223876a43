"""Wait for lifecycle nodes of other processes."""

import time

import rclpy
from lifecycle_msgs.msg import State
from lifecycle_msgs.srv import GetState
from rclpy.executors import SingleThreadedExecutor

TIMEOUT_S = 60.0
RETRY_S = 3.0  # without a response after which a request is repeated


def wait_until_active(domain, *nodes, alive=lambda: True):
    """Wait until all `nodes` (fully qualified names) of a ROS domain are active; fail once `alive` is false."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain)
    node = rclpy.create_node("lifecycle_observer", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    waiting = {name: node.create_client(GetState, f"{name}/get_state") for name in nodes}
    futures, end = {}, time.monotonic() + TIMEOUT_S
    try:
        while waiting:
            assert time.monotonic() < end, f"not active: {', '.join(waiting)}"
            assert alive(), "a process has ended"
            for name, client in list(waiting.items()):
                future, since = futures.get(name, (None, 0.0))
                if future is not None and future.done():
                    futures.pop(name)
                    if future.result().current_state.id == State.PRIMARY_STATE_ACTIVE:
                        del waiting[name]
                elif client.service_is_ready() and time.monotonic() - since > RETRY_S:
                    futures[name] = client.call_async(GetState.Request()), time.monotonic()
            executor.spin_once(timeout_sec=0.05)
    finally:
        node.destroy_node()
        rclpy.shutdown(context=context)
