# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""ROS 2 base of every node. Input: parameters. Output: a process with lifecycle, log, diagnostics and serialized messages.

Permitted imports: vsa_common.blas, vsa_common.config, ament_index_python, diagnostic_msgs, rcl_interfaces, rclpy
"""
