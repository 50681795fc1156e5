"""From recordings to shots that a joint fit can begin with."""
