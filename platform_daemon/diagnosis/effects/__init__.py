"""Effects that a diagnosis has names for, one module per kind."""
