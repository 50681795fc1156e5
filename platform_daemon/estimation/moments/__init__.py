"""What the samples say about a motion: one pass over them, half swing by half swing."""
