# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parts of the node. Input: messages, stamps, states. Output: samples, refused stamps, instants of predictions, files.

Permitted imports: rclpy, sensor_msgs, geometry_msgs, std_srvs, vsa_common.config, vsa_common.ros, vsa_common.stamps, vsa_common.types, vsa_msgs, vsa_estimator.offline, vsa_estimator.output, vsa_estimator.preprocessing, vsa_estimator.settings
"""
