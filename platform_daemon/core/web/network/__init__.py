"""Checks before the routes: roles, origins, limits, certificates."""
