# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Start values of the filter: by regression over the first seconds of motion, or those of a previous run.

Permitted imports: vsa_common, vsa_estimator.fault_detection, vsa_estimator.filter, vsa_estimator.force_law, vsa_estimator.modes, vsa_estimator.settings, vsa_estimator.tuning, numpy
"""
