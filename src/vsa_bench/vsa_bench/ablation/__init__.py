# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Sensitivity of the estimates to tuned constants. Input: registry of constants, recordings. Output: a table.

Permitted imports: vsa_common, vsa_estimator, vsa_bench.estimation, vsa_bench.mismatch, vsa_simulator.faults, vsa_simulator.rig, numpy
"""
