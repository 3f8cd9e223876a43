# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Impedance of the joint. Input: estimates of both transmissions. Output: impedance, tensions, variances.

Permitted imports: vsa_common, vsa_joint.geometry, vsa_joint.settings, vsa_joint.tuning, numpy
"""
