"""The index of what has been measured: `python -m tests.evidence`."""
