"""Driver, estimators and joint node of every joint in the parameter file, one process for each joint.

ros2 launch vsa_bringup composed.launch.py [config:=my_rig.yaml]
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Launch description."""
    default = PathJoinSubstitution([FindPackageShare("vsa_bringup"), "config", "paper_rig.yaml"])
    argument = DeclareLaunchArgument("config", default_value=default, description="parameter file of the rig")
    node = Node(package="vsa_bringup", executable="composed", parameters=[LaunchConfiguration("config")])
    return LaunchDescription([argument, node])
