"""Stiffness, damping and inertia of one transmission. Input: force and deflection. Output: estimates, state.

Permitted imports: vsa_common, vsa_msgs, rclpy, sensor_msgs, geometry_msgs, numpy
"""
