"""The noise of a record or a series: per channel, its spectrum, what stands steadily in it."""
