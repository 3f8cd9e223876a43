# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Raw samples become flagged, decimated samples. Input: stamps, forces, deflections. Output: SensorFlag bits, Decimated.

Permitted imports: vsa_common, vsa_estimator.tuning, vsa_estimator.settings, numpy
"""
