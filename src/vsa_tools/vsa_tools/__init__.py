"""Tools for users: demo, record, report, view, design. Input: options, topics, bags. Output: bags, figures, pages.

Permitted imports: vsa_common
"""
