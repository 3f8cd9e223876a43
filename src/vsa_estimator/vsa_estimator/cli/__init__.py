# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Command-line tools. Input: recordings. Output: CSV, JSON, parameter files, figures.

Permitted imports: vsa_common, vsa_estimator.formulations, vsa_estimator.offline, vsa_estimator.output, vsa_estimator.settings, ament_index_python, numpy, yaml
"""
