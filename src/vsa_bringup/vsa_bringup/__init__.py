"""Launch files, configuration, layouts and the composed executable. Input: a parameter file. Output: running nodes.

Permitted imports: rclpy, vsa_common, vsa_driver, vsa_estimator, vsa_joint
"""
