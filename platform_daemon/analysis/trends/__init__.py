"""Trends of a specimen over many recordings: when a change is more than chance, and what it is called.

look: What the index keeps of a recording.
indexed: Trends of the recordings in a folder, by its index; exported: all on-line fits of a specimen as one table.
baseline: Since when a specimen is what it is now.
trend: The trend of a specimen.
points: Shots that were made together are one point.
charts: The charts of all quantities; changes: what a change is called.
chart: A control chart of one quantity; prediction: what the points before say of the next one; ewma: limits from the
    false-alarm rate.
"""
