"""Numbers that budgets decide by, each with what sets it.

The chances are those of the normal distribution: `pytest tests/features/budget -k chances` draws them.
"""

DISAGREE_SD = 2.0
"""N50 and D30 disagree from so many standard deviations of their difference on: 4.6 % of right models are taken for
wrong ones, whose budget then has a line of at least 2 / sqrt(3) = 1.2 of them too many; a model whose error is three of
them is missed in 16 %.  A budget that is too wide is the cheaper mistake, so that the limit is no higher."""
CORRELATED_SD = 2.0
"""Over sqrt(n): the lag-1 autocorrelation of n white values has the mean -1/n and variance 1/n (Box and Jenkins), so
that 2.3 % of long series exceed it, and fewer short ones; they count as fewer independent shots than there are."""
REMANENCE_PER_K = -1.1e-3
"""Relative change of a NdFeB magnet's moment, 1/K, where nothing is declared: B_r changes by -0.09 to -0.12 %/K (data
sheets of magnets), and f_nat as the moment (paper eq:fnat, two magnets of one kind).  It tells what an undeclared
temperature would add, and is part of no U."""
