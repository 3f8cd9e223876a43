"""Benches for developers: each compares side by side in one run. Input: options. Output: tables, JSON, plots.

Permitted imports:
"""
