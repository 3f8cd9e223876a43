# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Driver, estimators and joint node in one process for each joint that the parameter file names.

ros2 launch vsa_bringup composed.launch.py config:=my_rig.yaml [namespace:=left] [--show-args]
"""

from launch import LaunchDescription
from vsa_bringup.arguments import AUTO
from vsa_bringup.deployment import COMPOSED
from vsa_bringup.launch_description import launch_description


def generate_launch_description() -> LaunchDescription:
    """Launch description."""
    return launch_description(__file__, COMPOSED, namespace=AUTO)
