"""Tools for users: demo, record, report, view, design."""
