"""CAN bus to force and encoder topics, motor commands to CAN."""
