# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Driver of the rig. Input: CAN frames, motor commands. Output: samples of all sensors in SI, command frames.

Permitted imports: vsa_common, vsa_msgs, rclpy, geometry_msgs, sensor_msgs, std_msgs, std_srvs
"""
