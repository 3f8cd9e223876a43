# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Calibration of a force sensor against a gauge. Input: recorded forces of both. Output: scale and offset, parameters.

Permitted imports: vsa_common, vsa_driver.settings, vsa_driver.tuning, numpy
"""
