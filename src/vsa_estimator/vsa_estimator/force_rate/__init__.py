# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Estimator of the paper's formulation, eqs. (14) to (17). Input: samples. Output: estimates and states.

Permitted imports: vsa_common, vsa_estimator.filter, vsa_estimator.force_law, vsa_estimator.modes, vsa_estimator.output, vsa_estimator.preprocessing, vsa_estimator.settings, vsa_estimator.tuning, filterpy, numpy, scipy
"""
