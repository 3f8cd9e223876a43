# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Scenarios of the demo: a schedule and its evaluation. Input: options, recorded run. Output: parameters, figures.

Permitted imports: vsa_tools.demo, vsa_tools.evaluation, vsa_tools.topics, vsa_common, vsa_joint, vsa_simulator, vsa_msgs, rclpy, diagnostic_msgs, std_srvs, ament_index_python, numpy, yaml
"""
