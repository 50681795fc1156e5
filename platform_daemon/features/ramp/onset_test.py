"""Whether side modes are visible at a field, tested shot by shot, right at any stopping time.

At every field the hypothesis is that the z residual lies at or below the visible level. For a size that scatters about
it no wider than a normal law of variance v, exp(l (x - level) - l^2 v / 2) has mean 1 at most, for every l >= 0. Its
product over the shots, averaged over l, is an e-process: it passes 1/a with a chance of at most a, whenever one stops
(Ville; Ramdas, Gruenwald, Vovk and Shafer, Statist. Sci. 38 (2023) 576). The k-th field visited has a / (k (k + 1)),
so that a is the chance of a false stop anywhere in a ramp.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import logsumexp

from .z_residual import VISIBLE_AM2_PER_S

_SLOPES = np.geomspace(0.2, 20.0, 40)  # l in units of 1 / sqrt(v)


class OnsetTest:
    """The test of one ramp.

    rate: chance of a false stop anywhere in it. level: visible level, A m^2/s.
    """

    def __init__(self, rate: float, level: float = VISIBLE_AM2_PER_S) -> None:
        self.rate, self.level = rate, level
        self._logs: dict[float, np.ndarray] = {}

    def see(self, field_t: float, size: float, sd: float) -> None:
        """One more shot at a field: its z residual and the standard deviation of that, scatter included."""
        scaled = (size - self.level) / sd
        before = self._logs.get(field_t, np.zeros(_SLOPES.size))
        self._logs[field_t] = before + _SLOPES * scaled - 0.5 * _SLOPES**2

    def log_evidence(self, field_t: float) -> float:
        """Logarithm of the e-value at a field; 0 without a shot there."""
        logs = self._logs.get(field_t)
        return 0.0 if logs is None else float(logsumexp(logs) - math.log(_SLOPES.size))

    def needed(self, field_t: float) -> float:
        """Logarithm from which side modes are visible there."""
        k = 1 + list(self._logs).index(field_t) if field_t in self._logs else 1 + len(self._logs)
        return math.log(k * (k + 1) / self.rate)

    def visible(self, field_t: float) -> bool:
        """Side modes are there, beyond the doubt stated."""
        return self.log_evidence(field_t) >= self.needed(field_t)
