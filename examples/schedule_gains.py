# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Torque control through a joint of variable stiffness: gain scheduling on the live estimate.

The joint is a spring of stiffness K between the motors and the link. The equilibrium angle sets its torque, so the gain
from torque to equilibrium angle is 1/K. Feedback of the angular velocity adds the damping that D lacks for the wanted
damping ratio. Both gains are scheduled on the present K and D, and kept while the estimate is invalid or imprecise.

    python examples/schedule_gains.py --ros-args -p torque:=0.1 -p stiffness:=1.0
"""

import contextlib
import math
from dataclasses import dataclass

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import JointState
from vsa_msgs.msg import JointImpedance, StiffnessCommand

LINK_INERTIA = 0.004  # [kg m^2] of the link
DAMPING_RATIO = 0.7  # of the link under control
MAX_INTERVAL = 0.2  # relative half width of the 95 % interval of K up to which K is used


@dataclass(frozen=True)
class Gains:
    """Equilibrium = torque * compliance - velocity * lead."""

    compliance: float  # [rad/(N m)]
    lead: float  # [s]


def schedule(joint: JointImpedance, before: Gains | None) -> Gains | None:
    """Gains for the present joint; those of `before` if the stiffness is invalid or its interval too wide.

    The stiffness that is used is the lower end of the 95 % interval for the lead and the upper end for the
    compliance, so that uncertainty reduces torque and damping.
    """
    if not joint.stiffness_valid:
        return before
    spread = 1.96 * math.sqrt(joint.stiffness_variance) / joint.stiffness
    if spread > MAX_INTERVAL:
        return before
    low, high = joint.stiffness * math.exp(-spread), joint.stiffness * math.exp(spread)
    wanted = 2.0 * DAMPING_RATIO * math.sqrt(low * LINK_INERTIA)
    has = joint.damping if joint.damping_valid else wanted
    return Gains(1.0 / high, max(0.0, wanted - has) / high)


class Scheduler(Node):
    """Publishes stiffness_command at the rate of its timer; nothing without an estimate, so that the motors hold."""

    def __init__(self) -> None:
        super().__init__("schedule_gains", namespace="vsa")
        self.torque = self.declare_parameter("torque", 0.1).value  # [N m]
        self.stiffness = self.declare_parameter("stiffness", 1.0).value  # [N m/rad]
        self.gains: Gains | None = None
        self.velocity = 0.0  # [rad/s]
        self.angle: tuple[float, float] | None = None
        self.commands = self.create_publisher(StiffnessCommand, "stiffness_command", 10)
        self.create_subscription(JointImpedance, "joint_impedance", self.on_joint, 10)
        self.create_subscription(JointState, "joint_states", self.on_angle, 10)
        self.create_timer(0.05, self.command)

    def on_joint(self, joint: JointImpedance) -> None:
        self.gains = schedule(joint, self.gains)

    def on_angle(self, state: JointState) -> None:
        time, angle = state.header.stamp.sec + 1e-9 * state.header.stamp.nanosec, state.position[0]
        if self.angle and time > self.angle[0]:
            slope, step = (angle - self.angle[1]) / (time - self.angle[0]), time - self.angle[0]
            self.velocity += (slope - self.velocity) * step / (0.02 + step)
        self.angle = time, angle

    def command(self) -> None:
        if self.gains is None:
            return
        equilibrium = self.torque * self.gains.compliance - self.velocity * self.gains.lead
        message = StiffnessCommand(equilibrium_angle=equilibrium, stiffness=self.stiffness)
        message.header.stamp, message.header.frame_id = self.get_clock().now().to_msg(), "joint"
        self.commands.publish(message)
        self.get_logger().info(f"equilibrium {equilibrium:.4f} rad for {self.torque:g} N m", throttle_duration_sec=1.0)


def main() -> None:
    rclpy.init()
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(Scheduler())


if __name__ == "__main__":
    main()
