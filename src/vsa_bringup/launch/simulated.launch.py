"""The suite on the simulated rig.

ros2 launch vsa_bringup simulated.launch.py [config:=my_rig.yaml] [namespace:=vsa]
"""

from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Launch description."""
    suite = PathJoinSubstitution([FindPackageShare("vsa_bringup"), "launch", "joint.launch.py"])
    rig = Node(
        package="vsa_simulator",
        executable="rig_simulator",
        name="rig_simulator",
        namespace=LaunchConfiguration("namespace"),
        parameters=[LaunchConfiguration("config")],
    )
    return LaunchDescription([IncludeLaunchDescription(PythonLaunchDescriptionSource(suite)), rig])
