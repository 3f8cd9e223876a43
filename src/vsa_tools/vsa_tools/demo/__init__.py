# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The demo: isolated processes of the suite with a simulated rig. Input: options. Output: bag, summary.json, report.

Permitted imports: vsa_tools.evaluation, vsa_tools.topics, vsa_common, vsa_estimator.settings, vsa_joint.settings, vsa_simulator.rig, vsa_msgs, rclpy, diagnostic_msgs, lifecycle_msgs, std_srvs, ament_index_python, numpy, yaml
"""
