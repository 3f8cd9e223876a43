# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Long runs of driver, filter and suite. Input: frames, hours, minutes. Output: invalid outputs, losses, memory growth.

Permitted imports: vsa_common, vsa_driver, vsa_estimator, vsa_simulator, vsa_msgs, vsa_tools, vsa_bench.harness, numpy
"""
