"""The regression of many shots on effects."""
