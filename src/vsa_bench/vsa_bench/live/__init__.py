# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Rate, delay and cost of the running suite. Input: modes, rates, joints. Output: a table and a figure.

Permitted imports: vsa_common, vsa_tools.demo, vsa_bench.harness, rclpy
"""
