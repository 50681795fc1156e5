"""Time derivatives of sampled channels."""

from __future__ import annotations

import math

import numpy as np

from .arrays import Array

WIDTH = 9
REACH = WIDTH // 2  # samples that a derivative needs on either side to be as good as it can be


def _weights(place: int) -> Array:
    """Of nine neighbouring samples for the derivative at one of them; exact for polynomials up to the eighth power."""
    offsets = np.arange(WIDTH) - place
    powers = np.array([[float(o) ** n / math.factorial(n) for o in offsets] for n in range(WIDTH)])
    return np.linalg.solve(powers, np.eye(WIDTH)[1])


_PLACES = [_weights(place) for place in range(WIDTH)]


def derivative(samples: Array, rate_hz: float) -> Array:
    """Time derivative of (..., n), n >= 9, from the nearest nine samples: centred but for four at either end."""
    inner = sum(w * samples[..., k : samples.shape[-1] - WIDTH + 1 + k] for k, w in enumerate(_PLACES[REACH]) if w)
    first = samples[..., :WIDTH] @ np.stack(_PLACES[:REACH], axis=1)
    last = samples[..., -WIDTH:] @ np.stack(_PLACES[REACH + 1 :], axis=1)
    return np.asarray(np.concatenate([first, inner, last], axis=-1) * rate_hz)
