# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Launch files, configuration, robot description, layouts and `composed`. Input: a parameter file. Output: running nodes.

Permitted imports: ament_index_python, launch, launch_ros, rclpy, vsa_common, vsa_driver, vsa_estimator, vsa_joint, xacro, yaml
"""
