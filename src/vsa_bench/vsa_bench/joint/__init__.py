# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Joint impedance: experiment against estimate. Input: simulated cases, or a bag. Output: table, JSON, figure.

Permitted imports: vsa_common, vsa_estimator, vsa_joint, vsa_simulator, numpy
"""
