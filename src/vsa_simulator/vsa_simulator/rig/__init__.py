"""Model of the rig. Input: configuration, motor commands, disturbance torque. Output: sensor readings, ground truth.

Permitted imports: vsa_common, numpy
"""
