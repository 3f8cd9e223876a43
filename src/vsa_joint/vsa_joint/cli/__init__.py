# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Command lines. Input: options, feedback of the action Excite. Output: tables, exit codes.

Permitted imports: vsa_common, vsa_joint.excitation.quantities, vsa_msgs, rclpy, action_msgs
"""
