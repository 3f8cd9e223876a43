# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Recordings and tables as files. Input: paths of rosbag2 bags or CSV files. Output: messages, bytes, numpy arrays.

Permitted imports: numpy, polars
"""
