"""The second estimator: harmonics instead of a fit."""
