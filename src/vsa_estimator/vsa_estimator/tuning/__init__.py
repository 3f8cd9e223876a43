"""Tuned constants of the estimator, a module for each folder. Output: values with unit, range, reason and evidence.

Permitted imports: vsa_common
"""
