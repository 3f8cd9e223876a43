"""The estimators and their peers on the same simulated recordings."""
