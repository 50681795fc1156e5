"""A dry friction that fluctuates along each ring-down: its courses, their statistics, and effects beside it."""
