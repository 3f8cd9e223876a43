# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Transmission of unknown laws: a bank of filters that are linear in the coefficients. Input: filter steps. Output: impedance.

Permitted imports: vsa_common, vsa_estimator.filter, vsa_estimator.force_law, vsa_estimator.settings, vsa_estimator.tuning, numpy
"""
