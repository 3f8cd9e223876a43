# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
import rclpy
from vsa_msgs.msg import JointImpedance


def on_joint(joint: JointImpedance) -> None:
    if joint.stiffness_valid:
        half_width = 1.96 * joint.stiffness_variance**0.5
        print(f"K = {joint.stiffness:.3f} +- {half_width:.3f} N m/rad", flush=True)


rclpy.init()
node = rclpy.create_node("controller")
node.create_subscription(JointImpedance, "/vsa/joint_impedance", on_joint, 10)
rclpy.spin(node)
