"""Driver, one estimator for each transmission, and the joint node, with one parameter file.

ros2 launch vsa_bringup joint.launch.py [config:=my_rig.yaml] [namespace:=vsa]
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

NODES = (
    ("vsa_driver", "driver", "driver"),
    ("vsa_estimator", "estimator", "estimator_1"),
    ("vsa_estimator", "estimator", "estimator_2"),
    ("vsa_joint", "joint", "joint"),
)


def generate_launch_description() -> LaunchDescription:
    """Launch description."""
    default = PathJoinSubstitution([FindPackageShare("vsa_bringup"), "config", "paper_rig.yaml"])
    config, namespace = LaunchConfiguration("config"), LaunchConfiguration("namespace")
    arguments = [
        DeclareLaunchArgument("config", default_value=default, description="parameter file of the rig"),
        DeclareLaunchArgument("namespace", default_value="vsa", description="namespace of the joint"),
    ]
    nodes = [
        Node(package=package, executable=executable, name=name, namespace=namespace, parameters=[config])
        for package, executable, name in NODES
    ]
    return LaunchDescription([*arguments, *nodes])
