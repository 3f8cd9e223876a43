# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tuned constants of the estimator, a module for each folder. Output: values with unit, range, reason and evidence.

Permitted imports: vsa_common
"""
