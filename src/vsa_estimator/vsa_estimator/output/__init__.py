# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Estimates and states for messages, CSV and callers. Input: filter state, samples. Output: Estimate, State, messages.

Permitted imports: vsa_common, vsa_msgs, vsa_estimator.filter, vsa_estimator.force_law, vsa_estimator.general, vsa_estimator.modes, vsa_estimator.preprocessing, vsa_estimator.tuning, std_msgs, numpy
"""
