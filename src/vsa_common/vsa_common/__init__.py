"""What several packages share: types, stamps, figures, terminal output, compilation. Input and output: see each module.

Permitted imports: matplotlib, numba, numpy, rich
"""
