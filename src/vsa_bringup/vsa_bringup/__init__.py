"""Launch files, configuration and the user's tools: demo, record, report, view, design, bench."""
