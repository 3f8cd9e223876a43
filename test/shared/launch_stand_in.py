# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The part of the launch API that the launch files use, for environments without ROS's launch system.

`install` puts modules of these names in place; `run` starts a launch file's processes as `ros2 launch` does. Command
lines, exit handlers and errors are those of launch 3.4 and launch_ros 0.26 (ROS 2 Jazzy).
"""

import importlib.util
import signal
import subprocess
import sys
import time
import types
from dataclasses import dataclass, field
from typing import Any

from vsa_common.ros.subprocesses import executable

POLL_S = 0.05
STOP_S = 10.0  # [s] from SIGINT to SIGKILL


@dataclass
class DeclareLaunchArgument:
    name: str
    default_value: str
    description: str

    def execute(self, context):
        context.launch_configurations.setdefault(self.name, self.default_value)
        return []


@dataclass
class OpaqueFunction:
    function: Any

    def execute(self, context):
        return self.function(context)


@dataclass
class Shutdown:
    reason: str


@dataclass
class Node:
    package: str
    executable: str
    name: str | None = None
    namespace: str | None = None
    parameters: list = field(default_factory=list)
    arguments: list = field(default_factory=list)
    ros_arguments: list = field(default_factory=list)
    output: str = "log"
    respawn: bool = False
    respawn_delay: float = 0.0
    on_exit: Shutdown | None = None

    def command(self):
        """Command line, in the order of launch_ros."""
        remaps = {"__node": self.name, "__ns": self.namespace}
        words = [executable(self.package, self.executable), *self.arguments, "--ros-args", *self.ros_arguments]
        words += [word for key, value in remaps.items() if value for word in ("-r", f"{key}:={value}")]
        return words + [word for file in self.parameters for word in ("--params-file", file)]


@dataclass
class LaunchDescription:
    entities: list


class LaunchContext:
    """Arguments of the command line and values of all arguments."""

    def __init__(self, argv):
        self.argv = argv
        self.launch_configurations = dict(word.split(":=", 1) for word in argv if ":=" in word)


def install():
    """Put the modules `launch` and `launch_ros` in place, if they are not installed; whether the real ones are."""
    if importlib.util.find_spec("launch") and importlib.util.find_spec("launch_ros"):
        return True
    for package, names, actions in (
        ("launch", (LaunchContext, LaunchDescription), (DeclareLaunchArgument, OpaqueFunction, Shutdown)),
        ("launch_ros", (), (Node,)),
    ):
        for name, members in ((package, names), (f"{package}.actions", actions)):
            module = types.ModuleType(name)
            module.__dict__.update({one.__name__: one for one in members})
            module.__path__ = []
            sys.modules[name] = module
    return False


def nodes(file, argv):
    """The Node actions of a launch file with arguments."""
    spec = importlib.util.spec_from_file_location("launch_file", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    context = LaunchContext(argv)
    return [node for entity in module.generate_launch_description().entities for node in entity.execute(context)]


class Running:
    """A Node action with its process."""

    def __init__(self, node):
        self.node = node
        self.start()

    def start(self):
        self.process = subprocess.Popen(self.node.command())
        print(f"[INFO] [{self.node.executable}]: process started with pid [{self.process.pid}]", flush=True)

    def end(self):
        """Wait for its end; SIGKILL after STOP_S."""
        try:
            self.process.wait(STOP_S)
        except subprocess.TimeoutExpired:
            self.process.kill()

    def has_ended(self):
        """Whether it has ended and is not started again; a shutdown of all raises KeyboardInterrupt."""
        if self.process.poll() is None:
            return False
        if self.node.respawn:
            time.sleep(self.node.respawn_delay)
            self.start()
            return False
        if self.node.on_exit:
            raise KeyboardInterrupt
        return True


def run(file, argv):
    """Start a launch file's processes and serve them until all have ended, or SIGINT; exit code as of `ros2 launch`."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    running = []
    try:
        for node in nodes(file, argv):
            running.append(Running(node))
        while running := [one for one in running if not one.has_ended()]:
            time.sleep(POLL_S)
    except KeyboardInterrupt:
        pass
    except Exception as error:
        print(f"[ERROR] [launch]: Caught exception in launch (see debug for traceback): {error}", file=sys.stderr)
        return 1
    finally:
        for one in running:
            one.process.send_signal(signal.SIGINT)
        for one in running:
            one.end()
    return 0
