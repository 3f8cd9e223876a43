# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Safety gate of motor commands. Input: commands and measured positions [rad]. Output: limited positions to send [rad].

Permitted imports: vsa_driver.tuning
"""
