"""Pydantic models that all features share."""
