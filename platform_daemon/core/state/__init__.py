"""State of the daemon other than recordings: durable writing, locks, events, audit, tokens, index."""
