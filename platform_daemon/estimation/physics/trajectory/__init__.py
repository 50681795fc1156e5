"""The motion of the model: half cycles solved, tabulated and chained, or traced sample by sample."""
