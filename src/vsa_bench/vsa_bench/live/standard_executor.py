# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""A node under rclpy's standard executor, for comparison: `python -m vsa_bench.live.standard_executor driver`."""

import importlib
import sys

from rclpy.executors import SingleThreadedExecutor
from vsa_common.config.joints import DEFAULT, joints
from vsa_common.ros.process import run

CLASSES = {
    "driver": "vsa_driver.node.DriverNode",
    "estimator_1": "vsa_estimator.node.EstimatorNode",
    "estimator_2": "vsa_estimator.node.EstimatorNode",
    "joint": "vsa_joint.node.JointNode",
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
