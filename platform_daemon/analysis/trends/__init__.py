"""Trends of a specimen over many recordings: when a change is more than chance, and what it is called."""
