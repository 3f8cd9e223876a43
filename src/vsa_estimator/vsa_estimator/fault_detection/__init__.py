# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Faults of sensors and changes of the transmission. Input: filter steps, sensor flags. Output: decisions, active faults.

Permitted imports: vsa_common, vsa_estimator.filter, vsa_estimator.force_law, vsa_estimator.general, vsa_estimator.law_selection, vsa_estimator.modes, vsa_estimator.preprocessing, vsa_estimator.tuning, numpy
"""
