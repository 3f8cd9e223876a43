# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Methods of other authors for comparison. Input: force and deflection, one row a recording. Output: estimates.

Permitted imports: vsa_common, vsa_estimator.force_rate, vsa_estimator.tuning, numpy, scipy
"""
