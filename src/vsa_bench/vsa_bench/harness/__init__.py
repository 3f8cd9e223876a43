# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Runs of the live suite for live, view and soak. Input: a case. Output: counts, delays, processor time and memory.

Permitted imports: vsa_common, vsa_msgs, vsa_tools.demo, diagnostic_msgs, rclpy, numpy
"""
