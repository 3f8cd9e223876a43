"""Runs of the live suite for live, view and soak. Input: a case. Output: counts, delays, processor time and memory.

Permitted imports: vsa_common, vsa_msgs, vsa_tools.demo, diagnostic_msgs, rclpy, numpy
"""
