"""CAN bus to force and encoder topics, motor commands to CAN, and the rig that stands in for hardware."""
