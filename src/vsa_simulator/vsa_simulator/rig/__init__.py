# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Model of the rig. Input: configuration, motor commands, disturbance torque. Output: sensor readings, ground truth.

Permitted imports: vsa_common, vsa_simulator.laws, numpy
"""
