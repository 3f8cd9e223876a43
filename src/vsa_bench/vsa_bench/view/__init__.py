# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Cost of the live page beside the running suite. Input: mode and rate. Output: a table of runs with and without it.

Permitted imports: vsa_common, vsa_tools.demo, vsa_bench.harness, vsa_bench.live, numpy
"""
