# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Report of a recording. Input: bag, truth.csv. Output: report.html, report.pdf, figures/*.png, coefficients.yaml.

Permitted imports: vsa_common, vsa_estimator.force_rate, vsa_estimator.offline, numpy
"""
