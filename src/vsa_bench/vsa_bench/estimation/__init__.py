# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Estimators and peers on simulated recordings. Input: cases and seeds. Output: scores, a table and a figure.

Permitted imports: vsa_common, vsa_estimator, vsa_simulator.rig, vsa_bench.peers, numpy, scipy
"""
