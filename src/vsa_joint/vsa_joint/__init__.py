"""Impedance and stiffness control of a joint. Input: transmission estimates. Output: impedance, motor commands.

Permitted imports: vsa_common, vsa_msgs, rclpy, diagnostic_msgs, sensor_msgs
"""
