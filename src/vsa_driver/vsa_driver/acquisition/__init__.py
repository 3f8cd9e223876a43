# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Frames to samples. Input: stamped frames, signal mapping, calibration. Output: samples in SI, counters.

Permitted imports: vsa_common, vsa_driver.can, vsa_driver.settings, vsa_driver.tuning, ament_index_python
"""
