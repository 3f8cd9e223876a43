"""Configuration as frozen dataclasses. Input: parameter files, or flat values. Output: checked configurations.

Permitted imports: yaml
"""
