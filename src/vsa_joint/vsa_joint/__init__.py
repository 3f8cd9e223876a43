"""Impedance of an antagonistic joint from its two transmissions, and stiffness control with it."""
