# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""CAN bus and DBC files. Input: interface parameters, frames. Output: frames with capture time, signal values.

Permitted imports: vsa_common, vsa_driver.tuning, can, cantools, ament_index_python
"""
