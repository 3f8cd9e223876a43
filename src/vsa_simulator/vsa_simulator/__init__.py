"""A simulated variable-stiffness joint on a real CAN bus interface, in place of hardware."""
