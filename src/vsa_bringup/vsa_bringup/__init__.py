"""Launch files, configuration, layouts and the composed executable."""
