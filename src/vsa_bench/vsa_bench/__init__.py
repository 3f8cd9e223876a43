"""Benches for developers: each compares side by side in one run."""
