"""Validation on held-out data."""
