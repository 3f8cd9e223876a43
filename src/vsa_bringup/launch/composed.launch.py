"""Driver, estimators and joint of every joint that the parameter file names, in one process.

ros2 launch vsa_bringup composed.launch.py [config:=my_rig.yaml]
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """What to start."""
    default = PathJoinSubstitution([FindPackageShare("vsa_bringup"), "config", "paper_rig.yaml"])
    argument = DeclareLaunchArgument("config", default_value=default, description="parameter file of the rig")
    node = Node(package="vsa_bringup", executable="composed", parameters=[LaunchConfiguration("config")])
    return LaunchDescription([argument, node])
