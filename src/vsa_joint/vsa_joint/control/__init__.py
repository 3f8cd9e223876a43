# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Stiffness control. Input: commands, joint impedance, springs, angle, motors. Output: motor positions, mode.

Permitted imports: vsa_common, vsa_joint.geometry, vsa_joint.impedance, vsa_joint.settings, vsa_joint.tuning
"""
