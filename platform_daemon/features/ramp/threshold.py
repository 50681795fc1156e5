"""Where the z residual passes the visible level, as far as the shots so far tell: a posterior of the threshold field.

The logarithm of the z residual is a Gaussian process in the field: a linear growth of unknown slope, plus
what is neither straight nor steady (an upper roll mode that locks and lets go makes the thread's z fall now and then).
The threshold is where a path first passes the level, so that a path that falls again does not unmake it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.numerics.blas_threads import one_thread_for_products

from .z_residual import VISIBLE_AM2_PER_S

_PATHS = 4000
_OFFSET_SD = 4.0  # of the logarithm at the first field
_SLOPE_SD = 6.0  # of the logarithm per doubling of the field
_WIGGLE_SD, _WIGGLE = 0.5, 0.1  # of the logarithm, over such a share of the field
_FLOOR_SD = 1.5  # of the logarithm of what does not stand out of the noise
_GRID = 0.005  # share of the field between the places where paths are looked at
_REACH = 1.3  # times the highest field seen
_SHOWN = 80  # points of the curve that is shown: more are closer than a person can see


@dataclass(frozen=True)
class ThresholdPosterior:
    """Fields (m,) T, rising, and paths of the z residual there (paths, m), A m^2/s."""

    fields_t: Array
    above: np.ndarray  # bool (paths, m): the path has passed the level at this field or below

    @classmethod
    def of(
        cls, fields_t: Sequence[float], sizes: Sequence[float], sds: Sequence[float],
        level: float = VISIBLE_AM2_PER_S, seed: int = 0,
    ) -> ThresholdPosterior:  # fmt: skip
        """From the mean z residual at each field and its standard deviation, A m^2/s.

        Raises:
            ValueError: no field.
        """
        if len(fields_t) == 0:
            raise ValueError("a threshold needs a field that was tried")
        one_thread_for_products()
        x = np.log(np.asarray(fields_t, dtype=np.float64))
        sizes_, sds_ = np.asarray(sizes, dtype=np.float64), np.asarray(sds, dtype=np.float64)
        floor = np.maximum(3.0 * sds_, 1e-3 * level)
        seen = sizes_ > floor
        y = np.log(np.where(seen, sizes_, 0.5 * floor)) - math.log(level)
        noise = np.where(seen, sds_ / np.maximum(sizes_, 1e-12), _FLOOR_SD)
        grid = np.arange(float(x.min()), float(x.max()) + math.log(_REACH), _GRID)
        places = np.unique(np.concatenate([x, grid]))
        first = float(x.min())
        known = _covariance(x, x, first) + np.diag(noise**2)
        across = _covariance(places, x, first)
        weights = np.linalg.solve(known, across.T).T
        mean = weights @ y
        spread = _covariance(places, places, first) - weights @ across.T
        values, vectors = np.linalg.eigh(0.5 * (spread + spread.T))
        draws = np.random.default_rng(seed).standard_normal((_PATHS, places.size))
        paths = mean + (draws * np.sqrt(np.maximum(values, 0.0))) @ vectors.T
        return cls(np.exp(places), np.maximum.accumulate(paths > 0.0, axis=1))

    def chance_below(self, field_t: float) -> float:
        """Chance that the threshold lies at or below a field."""
        place = min(int(np.searchsorted(self.fields_t, field_t * (1.0 + 1e-9), side="right")), self.fields_t.size) - 1
        return float(self.above[:, max(place, 0)].mean())

    def highest_field(self, chance: float) -> float:
        """The highest field at or below which the threshold lies with less than this chance; 0: none."""
        allowed = self.above.mean(axis=0) < chance
        return float(self.fields_t[np.flatnonzero(allowed)[-1]]) if allowed.any() else 0.0

    def curve(self) -> tuple[Array, Array]:
        """Fields (k,), T, rising, the first and the last among them, and the chance that the threshold lies at or below
        each, (k,); at most 80."""
        count = self.fields_t.size
        places = np.unique(np.linspace(0, count - 1, min(count, _SHOWN)).round().astype(int))
        return self.fields_t[places], np.asarray(self.above[:, places].mean(axis=0))

    def quantile(self, share: float) -> float | None:
        """The field below which the threshold lies with this chance; None: beyond what was looked at."""
        reached = self.above.mean(axis=0) >= share
        return float(self.fields_t[int(np.argmax(reached))]) if reached.any() else None


def _covariance(a: Array, b: Array, first: float) -> Array:
    """Of the logarithm of the z residual at logarithms of the field (m,) and (k,), (m, k)."""
    straight = _OFFSET_SD**2 + _SLOPE_SD**2 / math.log(2.0) ** 2 * np.outer(a - first, b - first)
    apart = math.sqrt(3.0) * np.abs(a[:, None] - b[None]) / _WIGGLE
    return np.asarray(straight + _WIGGLE_SD**2 * (1.0 + apart) * np.exp(-apart))
