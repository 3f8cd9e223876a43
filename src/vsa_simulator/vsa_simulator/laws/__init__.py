"""Force laws of the simulated transmission, one plug-in each: springs, dampers, friction, relaxation, hysteresis.

Input: parameters, deflection, velocity. Output: forces, slopes, rates of internal states.

Permitted imports: vsa_common, numpy
"""
