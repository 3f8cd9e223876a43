# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Analysis of whole recordings, and the recorder of live events. Input: recordings. Output: coefficients, noise, files.

Permitted imports: vsa_common, vsa_estimator.force_rate, vsa_estimator.general, vsa_estimator.output, vsa_estimator.preprocessing, vsa_estimator.settings, vsa_estimator.tuning, numpy, scipy, yaml
"""
