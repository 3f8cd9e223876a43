# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Excitation for first use. Input: estimates, measurements, a goal. Output: motor positions, which quantities are known.

Permitted imports: vsa_common, vsa_joint.settings, numpy
"""
