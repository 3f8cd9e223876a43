# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Faults of sensors and bus. Input: failure commands, true readings and frames. Output: faulty readings and frames.

Permitted imports: vsa_common, vsa_simulator.rig, numpy
"""
