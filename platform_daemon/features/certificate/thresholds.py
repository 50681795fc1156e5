"""The number that a certificate is refused by."""

MOST_CHI2_PER_DOF = 2.0
"""Of the median shot: beyond, more than half of what the fit leaves over is no noise.  Of shots that the model
describes the statistic of 10^4 samples scatters by 0.014, so that none of them comes near; between 1 and 2 the error of
the model is a line of the budget, as far as N50 and D30 disagree.  `accepted_misfit` of the details goes beyond it."""
