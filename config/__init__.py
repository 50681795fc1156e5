"""Shipped configuration: platforms, resonators and sequences; TOML files only."""
