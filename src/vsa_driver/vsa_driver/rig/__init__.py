"""The simulated rig: the physical truth that the estimators are judged by.

Pure: no clock, no CAN, no ROS, and not a line of what estimates from it.
"""
