"""Statistics over the fits of a series."""
