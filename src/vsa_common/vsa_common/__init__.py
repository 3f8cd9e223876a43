# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""What several packages share: types, stamps, figures, terminal output, compilation. Input and output: see each module.

Permitted imports: matplotlib, numba, numpy, rich
"""
