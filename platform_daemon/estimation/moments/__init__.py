"""What the samples say about a motion: one pass over them, half cycle by half cycle."""
