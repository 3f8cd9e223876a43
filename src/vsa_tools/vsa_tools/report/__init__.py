"""Report of a recording. Input: bag, truth.csv. Output: report.html, report.pdf, figures/*.png, coefficients.yaml.

Permitted imports: vsa_common, vsa_estimator.offline, vsa_estimator.tuning, numpy
"""
