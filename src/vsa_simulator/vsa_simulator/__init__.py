# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Simulated rig on a CAN bus. Input: parameters, scenario, command frames. Output: sensor frames, ground truth file.

Permitted imports: vsa_common, vsa_driver, vsa_msgs, std_srvs, yaml
"""
