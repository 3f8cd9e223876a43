# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The recorder: node and tool. Input: topics of one namespace, serialized. Output: a rosbag2 recording (MCAP).

Permitted imports: vsa_tools.topics, vsa_common, rclpy
"""
