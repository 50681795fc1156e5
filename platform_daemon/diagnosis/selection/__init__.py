"""The search for effects, and the decision which are accepted."""
