"""What all features share: schemas, jobs, recordings, state, hardware, guard, service and web."""
