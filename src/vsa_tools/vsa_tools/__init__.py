# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tools for users: demo, record, report, view, design. Input: options, topics, bags. Output: bags, figures, pages.

Permitted imports: vsa_bringup.arguments, vsa_common
"""
