# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The live page of one joint. Input: the suite's topics. Output: HTTP page and WebSocket frames.

Permitted imports: vsa_tools.topics, vsa_common, vsa_estimator.force_rate, vsa_estimator.modes, vsa_msgs, rclpy, diagnostic_msgs, sensor_msgs, aiohttp
"""
