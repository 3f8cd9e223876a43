"""Recordings and tables as files. Input: paths of rosbag2 bags or CSV files. Output: messages, bytes, numpy arrays.

Permitted imports: numpy, polars
"""
