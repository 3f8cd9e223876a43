"""`./vsa bench live`: the whole suite running, measured from outside."""
