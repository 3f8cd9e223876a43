# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Stiffness, damping and inertia of one transmission. Input: force and deflection. Output: estimates, state.

Permitted imports: vsa_common, vsa_msgs, rclpy, numpy
"""
