"""One folder for each feature: schema, work, routes, command and report, as far as the feature needs them."""
