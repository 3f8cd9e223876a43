"""Parts of the node. Input: stamps, states. Output: refused stamps, instants of predictions, diagnostics.

Permitted imports: rclpy, vsa_common.ros, vsa_common.types, vsa_estimator.output
"""
