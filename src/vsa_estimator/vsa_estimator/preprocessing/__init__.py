"""Raw samples become flagged, decimated samples. Input: stamps, forces, deflections. Output: SensorFlag bits, Decimated.

Permitted imports: vsa_common, vsa_estimator.tuning, vsa_estimator.settings, numpy
"""
