# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`launch_file.py FILE [NAME:=VALUE ...]`: as `ros2 launch FILE ...`, by the launch system or by its stand-in."""

import sys

import launch_stand_in


def run_real(file, argv):
    """As the function `launch_a_launch_file` of ros2launch."""
    from launch import LaunchDescription, LaunchService
    from launch.actions import IncludeLaunchDescription
    from launch.launch_description_sources import AnyLaunchDescriptionSource

    arguments = [tuple(word.split(":=", 1)) for word in argv]
    service = LaunchService(argv=argv, noninteractive=True)
    source = IncludeLaunchDescription(AnyLaunchDescriptionSource(file), launch_arguments=arguments)
    service.include_launch_description(LaunchDescription([source]))
    return service.run()


if __name__ == "__main__":
    file, *argv = sys.argv[1:]
    sys.exit(run_real(file, argv) if launch_stand_in.install() else launch_stand_in.run(file, argv))
