# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Driver, one estimator for each transmission, and the joint node, with one parameter file.

ros2 launch vsa_bringup joint.launch.py config:=my_rig.yaml [namespace:=left] [--show-args]
"""

from launch import LaunchDescription
from vsa_bringup.deployment import SEPARATE
from vsa_bringup.launch_description import launch_description


def generate_launch_description() -> LaunchDescription:
    """Launch description."""
    return launch_description(__file__, SEPARATE)
