"""Array types used throughout: float64 unless a docstring says otherwise."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
ComplexArray = NDArray[np.complex128]

_LARGEST_GROWTH = 3.0


def grown(value: float, step: float) -> float:
    """A value other than 0 after a step that multiplies it; never of the other sign, at most twentyfold."""
    return value * math.exp(min(max(step / value, -_LARGEST_GROWTH), _LARGEST_GROWTH))
