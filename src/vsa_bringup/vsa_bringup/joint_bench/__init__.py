"""The joint's validation experiment on the simulated rig, through the pure cores, faster than real time."""
