# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Extended Kalman filter of one transmission. Input: averaged force and deflection. Output: state, covariance, impedance.

Permitted imports: vsa_common, vsa_estimator.force_law, vsa_estimator.settings, vsa_estimator.tuning, numpy
"""
