"""From the residual of measured ring-downs to the effect that the model lacks, with proof by held-out data."""
