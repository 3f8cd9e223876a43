# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Identification with held motors. Input: external torque, joint angle. Output: impedance, standard deviations.

Permitted imports: vsa_common, vsa_joint.geometry, vsa_joint.impedance, vsa_joint.tuning, numpy
"""
