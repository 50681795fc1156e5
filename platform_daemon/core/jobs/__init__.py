"""Jobs: record, registry, queue, progress and the pool of worker processes."""
