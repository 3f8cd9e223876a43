# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Benches for developers: each compares side by side in one run. Input: options. Output: tables, JSON, plots.

Permitted imports:
"""
