# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Figures of merit of a recorded run against the rig's truth. Input: bag, truth.csv, parameters. Output: summary.json.

Permitted imports: vsa_tools.topics, vsa_common, vsa_estimator.settings, vsa_joint.impedance, vsa_simulator, numpy
"""
