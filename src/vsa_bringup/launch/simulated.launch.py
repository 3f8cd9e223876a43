# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The suite on the simulated rig; a namespace other than vsa has a bus of its own.

ros2 launch vsa_bringup simulated.launch.py [namespace:=left] [view:=true] [--show-args]
"""

from launch import LaunchDescription
from vsa_bringup.deployment import RIG, SEPARATE
from vsa_bringup.launch_description import launch_description


def generate_launch_description() -> LaunchDescription:
    """Launch description."""
    return launch_description(__file__, (*SEPARATE, RIG))
