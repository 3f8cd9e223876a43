# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Estimator and peers on transmissions and sensors that differ from the paper's. Input: cases. Output: figures, bars.

Permitted imports: vsa_common, vsa_estimator, vsa_simulator, vsa_bench.estimation, vsa_bench.peers, numpy
"""
