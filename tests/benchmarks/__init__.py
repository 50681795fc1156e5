"""How fast the fit is, beside the method of the paper and the demodulation floor."""
