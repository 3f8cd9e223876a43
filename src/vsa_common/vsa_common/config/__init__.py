# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Configuration as frozen dataclasses. Input: parameter files, or flat values. Output: checked configurations.

Permitted imports: yaml
"""
