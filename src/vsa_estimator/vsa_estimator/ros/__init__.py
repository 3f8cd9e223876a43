# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parts of the node. Input: stamps, states. Output: refused stamps, instants of predictions, diagnostics, files.

Permitted imports: rclpy, std_srvs, vsa_common.config, vsa_common.ros, vsa_common.types, vsa_msgs, vsa_estimator.offline, vsa_estimator.output, vsa_estimator.settings
"""
