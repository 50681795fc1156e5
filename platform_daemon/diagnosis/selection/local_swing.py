"""A few periods of any swing as a sum of harmonics of slowly changing size, with samples lost in the middle or not."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import minimize_scalar

from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array

_LIMITS = THRESHOLDS.selection


@dataclass(frozen=True, kw_only=True)
class Stretch:
    """Samples to be searched.

    Attributes:
        samples: (channels, n). sd: (channels,) of their noise.
        frequency: (instant in samples) -> local frequency in cycles per sample.
        periods: half width of a window.
        points: per period, to which samples are averaged for the search.
    """

    samples: Array
    sd: Array
    frequency: Callable[[float], float]
    periods: float
    points: int


def block_means(samples: Array, block: int) -> Array:
    """Means of `block` neighbours each, (channels, points), of samples (channels, n)."""
    n = samples.shape[1] // block
    return np.asarray(samples[:, : n * block].reshape(samples.shape[0], n, block).mean(axis=2))


def waves(
    time: Array,
    frequency: float,
    scale: float,
    *,
    degrees: int = _LIMITS.swing_degrees,
    harmonics: Sequence[int] = _LIMITS.swing_harmonics,
) -> tuple[Array, Array]:
    """Harmonics (columns, points) of slowly changing size at times from the window's centre, and their derivatives.

    degrees: powers of the time over `scale` that the size of each may have, from 0 on.
    """
    x = time / scale
    turn = 2.0 * math.pi * frequency
    rows, slopes = [], []
    for degree in range(degrees):
        slow, change = x**degree, (degree * x ** max(degree - 1, 0) if degree else np.zeros_like(x)) / scale
        rows.append(slow)
        slopes.append(change)
        for h in harmonics:
            c, s = np.cos(h * turn * time), np.sin(h * turn * time)
            rows += [slow * c, slow * s]
            slopes += [change * c - slow * h * turn * s, change * s + slow * h * turn * c]
    return np.stack(rows), np.stack(slopes)


@dataclass(frozen=True, kw_only=True)
class Window:
    """Samples (channels, n) in units of their noise, their times from the window's centre, and its local frequency."""

    y: Array
    time: Array
    frequency: float
    half: float

    def split(self, at: int) -> Blocks:
        """Means of neighbours, none of which lie on both sides of a sample."""
        block = max(1, int(1.0 / (self.frequency * _LIMITS.fine_points)))
        early, late = self.y[:, at % block : at], self.y[:, at:]
        parts = [(at % block, early), (at, late)]
        means = [block_means(part, block) * math.sqrt(block) for _, part in parts]
        starts = [begin + np.arange(m.shape[1]) * block for (begin, _), m in zip(parts, means, strict=True)]
        time = self.time[0] + np.concatenate(starts) + 0.5 * (block - 1)
        after = np.concatenate([np.full(m.shape[1], k, dtype=bool) for k, m in enumerate(means)])
        return Blocks(
            y=np.concatenate(means, axis=1),
            time=time,
            after=after,
            weight=math.sqrt(block),
            frequency=self.frequency,
            half=self.half,
        )

    def place(self, at: int, size: float) -> int:
        """The first sample behind the loss: before it the swing is on time, from it on it is late."""
        inside, _ = self.split(at).fitted(size)
        reach = round(_LIMITS.place_reach_periods / self.frequency)
        first, last = max(0, at - reach), min(self.time.size, at + reach)
        there = self.time[first:last]
        early = self.y[:, first:last] - inside @ waves(there, self.frequency, self.half)[0]
        late = self.y[:, first:last] - inside @ waves(there + size, self.frequency, self.half)[0]
        before = np.concatenate([[0.0], np.cumsum(np.sum(early**2, axis=0))])
        after = np.concatenate([[0.0], np.cumsum(np.sum(late**2, axis=0))])
        return first + int(np.argmin(before + after[-1] - after))


@dataclass(frozen=True, kw_only=True)
class Blocks:
    """Means (channels, points) in units of their noise, `weight` times the waves; bool (points,): behind the loss."""

    y: Array
    time: Array
    after: np.ndarray
    weight: float
    frequency: float
    half: float

    @cached_property
    def _products(self) -> tuple[tuple[Array, Array, Array, Array], float]:
        """Waves times waves and waves times samples, of what is before the place and behind it; samples squared."""
        rows = self.weight * waves(self.time, self.frequency, self.half)[0]
        early, late = rows[:, ~self.after], rows[:, self.after]
        before, behind = self.y[:, ~self.after], self.y[:, self.after]
        return (early @ early.T, early @ before.T, late @ late.T, late @ behind.T), float(np.sum(self.y**2))

    def fitted(self, size: float) -> tuple[Array, float]:
        """Sizes of the waves (channels, columns) for `size` lost samples, and chi^2."""
        inside, chi2 = self._of(np.array([size]))
        return np.asarray(inside[0].T), float(chi2[0])

    def chi2(self, size: float) -> float:
        """chi^2 for `size` lost samples; of repeated ones the size is negative."""
        return float(self._of(np.array([size]))[1][0])

    def _of(self, lost: Array) -> tuple[Array, Array]:
        """Sizes of the waves (k, columns, channels) for each of (k,) numbers of lost samples, and chi^2 (k,).

        Waves at later times are the same waves, turned and mixed: the samples are summed over once for all of them.
        """
        (early, before, late, behind), power = self._products
        later = _later(lost, self.frequency, self.half)
        square, along = early + later @ late @ later.swapaxes(1, 2), before + later @ behind
        # At few samples per period high harmonics look like low ones: the weight on the diagonal shares between them.
        weight = _LIMITS.ridge_share * np.trace(square, axis1=1, axis2=2) / square.shape[1]
        inside = np.linalg.solve(square + weight[:, None, None] * np.eye(square.shape[1]), along)
        chi2 = power + np.sum(inside * (square @ inside - 2.0 * along), axis=(1, 2))
        return inside, np.maximum(chi2, 0.0)

    def kicked(self) -> float:
        """chi^2 with a free oscillation in addition that starts at the place: a kick."""
        since = np.where(self.after, self.time - self.time[self.after][0], 0.0)
        turn = 2.0 * math.pi * self.frequency
        more = np.stack([np.sin(turn * since), (1.0 - np.cos(turn * since)) * self.after])
        rows = self.weight * np.concatenate([waves(self.time, self.frequency, self.half)[0], more])
        return float(np.sum((self.y - _sizes(rows, self.y) @ rows) ** 2))

    def sizes(self, *, repeated: bool) -> list[float]:
        """Losses of up to two periods that explain about as well as the best does, smallest first.

        repeated: repeats of samples, whose sizes are negative, are tried too.
        """
        repeats = int(_LIMITS.most_repeated_periods * _LIMITS.tried_losses) if repeated else 0
        tried = np.arange(-repeats, 2 * _LIMITS.tried_losses + 1) / (self.frequency * _LIMITS.tried_losses)
        found = self._of(tried)[1]
        lowest = [k for k in range(len(found)) if found[k] == found[max(0, k - 1) : k + 2].min()]
        polished = [(self.chi2(s), s) for s in (self.polished(float(tried[k]), float(tried[0])) for k in lowest)]
        least = min(polished)[0]
        as_good = [s for chi2, s in polished if chi2 <= least * (1.0 + _LIMITS.as_good_chi2 / self.y.size)]
        return sorted(as_good, key=abs)

    def polished(self, around: float, least: float = -math.inf) -> float:
        """A loss near one and from a least one on, not necessarily whole, that explains best."""
        width = 1.0 / (self.frequency * _LIMITS.tried_losses)
        bounds = (max(around - width, least), around + width)
        return float(
            minimize_scalar(self.chi2, bounds=bounds, method="bounded", options={"xatol": _LIMITS.loss_tolerance}).x
        )


def window(stretch: Stretch, near: int, periods: float) -> tuple[Window, int]:
    """The samples around one, and which is the first of them."""
    frequency = stretch.frequency(float(near))
    half = round(periods / frequency)
    first, last = max(0, near - half), min(stretch.samples.shape[1], near + half)
    y = stretch.samples[:, first:last] / stretch.sd[:, None]
    return Window(y=y, time=np.arange(last - first) - float(near - first), frequency=frequency, half=float(half)), first


def _later(lost: Array, frequency: float, scale: float) -> Array:
    """(k, columns, columns): waves(time + lost) from waves(time), of each of (k,) numbers of lost samples."""
    shift, turns = lost / scale, 2.0 * math.pi * frequency * lost
    slow = np.zeros((lost.size, _LIMITS.swing_degrees, _LIMITS.swing_degrees))
    for d in range(_LIMITS.swing_degrees):
        for k in range(d + 1):
            slow[:, d, k] = math.comb(d, k) * shift ** (d - k)
    turned = np.zeros((lost.size, 2 * len(_LIMITS.swing_harmonics) + 1, 2 * len(_LIMITS.swing_harmonics) + 1))
    turned[:, 0, 0] = 1.0
    for k, h in enumerate(_LIMITS.swing_harmonics):
        cosine, sine = 2 * k + 1, 2 * k + 2
        turned[:, cosine, cosine] = turned[:, sine, sine] = np.cos(h * turns)
        turned[:, sine, cosine] = np.sin(h * turns)
        turned[:, cosine, sine] = -turned[:, sine, cosine]
    n = slow.shape[1] * turned.shape[1]
    return (slow[:, :, None, :, None] * turned[:, None, :, None, :]).reshape(lost.size, n, n)


def _sizes(rows: Array, y: Array) -> Array:
    """Least squares by normal equations: columns are of one size, and there are many rows."""
    return np.asarray(np.linalg.lstsq(rows @ rows.T, rows @ y.T, rcond=_LIMITS.wave_rank)[0].T)
