"""A node under rclpy's ordinary executor, for comparison: `python -m vsa_bringup.live_bench.ordinary driver`."""

import importlib
import sys

from rclpy.executors import SingleThreadedExecutor
from vsa_common.joints import DEFAULT, joints
from vsa_common.life import run

CLASSES = {
    "driver": "vsa_driver.driver.DriverNode",
    "estimator_1": "vsa_estimator.node.EstimatorNode",
    "estimator_2": "vsa_estimator.node.EstimatorNode",
    "joint": "vsa_joint.joint.JointNode",
}


def main() -> int:
    """Entry point; the first argument is the node's name."""
    name = sys.argv[1]
    module, _, node = CLASSES[name].rpartition(".")
    node_class = getattr(importlib.import_module(module), node)
    return run(
        lambda: [node_class(name, space) for space in (joints(sys.argv) if name == "driver" else [DEFAULT])],
        executor=SingleThreadedExecutor,
    )


if __name__ == "__main__":
    sys.exit(main())
