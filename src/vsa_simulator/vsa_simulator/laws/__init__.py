# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Force laws of the simulated transmission, one plug-in each: springs, dampers, friction, relaxation, hysteresis.

Input: parameters, deflection, velocity. Output: forces, slopes, rates of internal states.

Permitted imports: vsa_common, numpy
"""
