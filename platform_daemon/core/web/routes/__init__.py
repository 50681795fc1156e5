"""Routes that belong to no feature: platform, catalogue, events, stop."""
