"""A friction or a frequency that fluctuates along each ring-down: courses, their statistics, and effects beside it."""
