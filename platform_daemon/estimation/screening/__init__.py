"""What the samples alone tell, before any model: frequency, periods, saturation, windows."""
