"""Identification with held motors. Input: external torque, joint angle. Output: impedance, standard deviations.

Permitted imports: vsa_common, vsa_joint.geometry, vsa_joint.impedance, vsa_joint.tuning, numpy
"""
