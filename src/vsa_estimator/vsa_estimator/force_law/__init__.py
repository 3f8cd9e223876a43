# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Force law of one transmission, eqs. (2) to (6). Input: filter state. Output: force, gradient, Hessian.

Permitted imports: vsa_common, vsa_estimator.tuning, numpy
"""
