"""The simulated devices: each is a thin face of the one `World`, speaking the contract of its kind."""
