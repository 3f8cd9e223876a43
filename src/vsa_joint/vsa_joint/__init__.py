# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Impedance and stiffness control of a joint. Input: transmission estimates. Output: impedance, motor commands.

Permitted imports: vsa_common, vsa_msgs, rclpy, diagnostic_msgs, sensor_msgs, std_msgs
"""
