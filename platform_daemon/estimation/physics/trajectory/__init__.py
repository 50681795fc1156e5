"""The motion of the model: half swings solved, tabulated and chained, or traced sample by sample."""
