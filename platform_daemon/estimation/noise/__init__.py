"""The noise of a record or a series: per channel, its spectrum, and the steady tones in it."""
