"""The results of a diagnosis."""
