# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Fault detection on simulated recordings, healthy and faulty. Input: cases and seeds. Output: figures, tables.

Permitted imports: vsa_common, vsa_estimator, vsa_simulator, vsa_bench.estimation, vsa_bench.mismatch, numpy, scipy
"""
