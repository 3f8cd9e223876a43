"""Stiffness, damping and inertia of one exponential-spring transmission from its force and deflection."""
