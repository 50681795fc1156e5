"""From a motion and its observation to the minimum, its covariance and the published parameters."""
