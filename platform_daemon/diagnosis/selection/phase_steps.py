"""Samples that a clock has lost, seen in the samples themselves: the swing goes on, but later than it should.

In windows of few periods any swing is a sum of harmonics of slowly changing size, whatever its torques are. Where
samples are missing, what comes after is the same sum a whole number of samples later. A torque bends the phase slowly;
a kick turns it too, but leaves the angle where it was. So no model of the motion is asked, and none is misled.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import irfft, rfft

from platform_daemon.estimation import Array

from .local_swing import Blocks, Stretch, Window, block_means, waves, window
from .significance import log_chance

_ALIKE = 0.005  # frequencies for which one set of waves serves
_SURE = -30.0  # logarithm of the chance of a step anywhere in a record without one
_EXPLAINED = 0.7  # share of the misfit of its window that a step must explain
_WHOLE = 0.1  # of a sample, by which its size may miss a whole number
_SEEN = 6.0  # standard deviations of the size of a loss
_SCALES = (1.0, 0.5)  # of a window
_MARGIN = 0.3  # periods on either side that must be seen
_BESIDE = (-0.12, -0.06, -0.02, 0.0, 0.02, 0.06, 0.12)  # of a period
_MOST_MOVES = 4  # of the place of a step
_LOOKED_AT = 6  # windows of either kind
_AT_ONCE = 64  # windows in memory
_FOLLOWED = 1.5  # chi^2 per value of waves that follow the swing
_OUT = 5.0  # times the misfit of a neighbour
_ODD = 20.0  # times the usual misfit
_UNSEEN = 1e-9  # share of a column beside the waves that rounding leaves
_KICK = 25.0  # by which the fall of chi^2 must exceed that by a kick


@dataclass(frozen=True)
class PhaseStep:
    """Lost samples.

    Attributes:
        at: first sample after them. samples: how many, whole; size, sd: as they were measured.
        log_p: logarithm of the chance of such a step by noise.
        filled: (channels, samples) what the swing would have shown there.
    """

    at: int
    samples: int
    size: float
    sd: float
    log_p: float
    filled: Array


def lost_samples(stretch: Stretch) -> list[PhaseStep]:
    """Losses that are beyond doubt, in the order of time, no two of them within one window."""
    block = max(1, int(1.0 / (stretch.frequency(0.0) * stretch.points)))
    means = block_means(stretch.samples, block) / stretch.sd[:, None] * math.sqrt(block)
    suspects: dict[int, float] = {}
    for share in _SCALES:
        windows = _scan(replace(stretch, periods=share * stretch.periods), means, block)
        suspects |= dict(_suspect(windows, means.shape[1], block * stretch.points))
    found: list[PhaseStep] = []
    for at in sorted(suspects, key=lambda at: suspects[at]):
        reach = 2.0 * stretch.periods / stretch.frequency(float(at))
        if all(abs(at - f.at) > reach for f in found):
            step = _measured(stretch, at)
            if step is not None and all(abs(step.at - f.at) > reach for f in found):
                found.append(step)
    return sorted(found, key=lambda f: f.at)


@dataclass(frozen=True)
class _Scanned:
    """A window: fall of chi^2 by its best step over the noise of what that leaves, its instant, misfit per value."""

    gain: float
    at: int
    misfit: float


def _suspect(windows: Sequence[_Scanned], count: int, apart: int) -> Iterator[tuple[int, float]]:
    """(instant, logarithm of the chance) of what is worth a closer look, the likeliest of those near each other.

    A step by a good part of a period is none to first order: there the window as a whole is far from its like.
    """
    usual = float(np.median([w.misfit for w in windows])) if windows else 0.0
    sure = [w for w in windows if log_chance(w.gain, 1, float(count)) < _SURE]
    odd = [w for w in windows if w.misfit > _ODD * max(usual, 1.0)]
    for at in _middles([w.at for w in odd], apart)[:_LOOKED_AT]:
        yield at, _SURE
    for some, size in ((odd, lambda w: w.misfit), (sure, lambda w: w.gain)):
        taken: list[int] = []
        for w in sorted(some, key=size, reverse=True):
            if len(taken) < _LOOKED_AT and all(abs(w.at - t) > apart for t in taken):
                taken.append(w.at)
                yield w.at, min(_SURE, log_chance(w.gain, 1, float(count)))


def _middles(places: Sequence[int], apart: int) -> list[int]:
    """Of runs of places that lie near each other: a loss stands in every window that holds it."""
    runs: list[list[int]] = []
    for at in sorted(places):
        if runs and at - runs[-1][-1] < apart:
            runs[-1].append(at)
        else:
            runs.append([at])
    return [round(0.5 * (run[0] + run[-1])) for run in runs]


def _scan(stretch: Stretch, means: Array, block: int) -> list[_Scanned]:
    """Every window with its best step."""
    found: list[_Scanned] = []
    for (frequency, points, place), firsts in _windows(stretch, means.shape[1], block).items():
        time = np.arange(points, dtype=np.float64) - 0.5 * points
        rows, slopes = waves(time, math.exp(_ALIKE * frequency), 0.5 * points)
        q = np.linalg.qr(rows.T)[0]
        # Derivatives of a window's fit, from its part within the waves.
        moved = np.linalg.lstsq(rows.T, q, rcond=None)[0].T @ slopes
        places = range(max(place, 4), min(place + _step(stretch), points - 4))
        if places:
            for k in range(0, len(firsts), _AT_ONCE):
                some = firsts[k : k + _AT_ONCE]
                y = np.stack([means[:, first : first + points] for first in some])
                gains, best, misfits = _best_in(y, q, moved, places)
                found += [
                    _Scanned(float(g), (first + int(at)) * block, float(m))
                    for first, g, at, m in zip(some, gains, best, misfits, strict=True)
                ]
    return sorted(found, key=lambda w: w.at)


def _step(stretch: Stretch) -> int:
    """From window to window, in points."""
    return max(1, int(stretch.points * stretch.periods) // 6)


def _windows(stretch: Stretch, count: int, block: int) -> dict[tuple[int, int, int], list[int]]:
    """First points of the windows, by what they have in common: frequency in steps, points, first place of a step."""
    found: dict[tuple[int, int, int], list[int]] = {}
    for centre in range(0, count, _step(stretch)):
        frequency = stretch.frequency((centre + 0.5) * block) * block
        half = round(stretch.periods / frequency)
        first, last = max(0, centre - half), min(count, centre + half)
        if last - first > half:
            key = round(math.log(frequency) / _ALIKE), last - first, centre - first
            found.setdefault(key, []).append(first)
    return found


def _best_in(y: Array, q: Array, slopes: Array, places: range) -> tuple[Array, Array, Array]:
    """Fall of chi^2 by a step over what that leaves per value, its place, chi^2 per value without; of windows (w,).

    y: (w, channels, points).
    """
    inside = y @ q
    left = y - inside @ q.T
    slope = inside @ slopes
    # What is late is a slope from some place on: sums from the last place on, and those in between, give all at once.
    between = slope[..., places.start : places.stop]
    late, after = slope[..., places.stop :], left[..., places.stop :]
    along = _from((between * left[..., places.start : places.stop]).sum(axis=1), (late * after).sum(axis=(1, 2)))
    whole = _from((between**2).sum(axis=1), (late**2).sum(axis=(1, 2)))
    inner = np.moveaxis(between[..., None] * q[places.start : places.stop], 2, 1)
    within = _from(inner, late @ q[places.stop :])
    power = np.maximum(whole - np.einsum("wkcq,wkcq->wk", within, within), _UNSEEN * whole + 1e-300)
    fall = along**2 / power
    best = np.argmax(fall, axis=1)
    misfit = np.sum(left**2, axis=(1, 2)) / max(left[0].size - y.shape[1] * q.shape[1], 1)
    gain = fall[np.arange(y.shape[0]), best]
    for w in np.flatnonzero(gain > -_SURE):  # less is by chance, and most windows hold no more
        at = best[w]
        column = np.where(np.arange(y.shape[2]) >= places[at], slope[w], 0.0) - within[w, at] @ q.T
        gain[w] /= max(_variance(left[w] - (along[w, at] / power[w, at]) * column, q.shape[1]), 1.0)
    return gain, places.start + best, misfit


def _from(values: Array, rest: Array) -> Array:
    """Sums of values (w, places, ...) from each place on, and of what comes after all of them, (w, ...)."""
    return np.asarray(np.cumsum(values[:, ::-1], axis=1)[:, ::-1] + rest[:, None])


def _variance(rest: Array, fitted: int) -> float:
    """Of white noise that would be worth as little as this residual (channels, points), whose values go together."""
    n = rest.shape[1]
    lags = irfft(np.sum(np.abs(rfft(rest, 2 * n, axis=1)) ** 2, axis=0), 2 * n)[: n // 4]
    together = 2.0 * float(np.sum((lags / max(lags[0], 1e-300)) ** 2)) - 1.0
    return float(lags[0]) / (rest.shape[0] * max(n - fitted, 1)) * max(1.0, together - 0.5)


def _measured(stretch: Stretch, near: int) -> PhaseStep | None:
    """The step near a sample, at every sample; None if it is none of whole samples, or a kick explains as much.

    A long window tells how many are lost (a short one hardly tells a loss from one that is a period longer), a short
    one where: there the waves follow any swing.
    """
    at = _begun(stretch, near)
    for _ in range(_MOST_MOVES):
        wide, begin = window(stretch, at, stretch.periods)
        seen, first = window(stretch, at, _SCALES[-1] * stretch.periods)
        margin = _MARGIN / seen.frequency
        if not margin < at - first < seen.time.size - margin:
            return None
        size = _size(wide.split(at - begin), seen.split(at - first))
        there = first + seen.place(at - first, size)
        if there == at:
            break
        at = there
    if not _stands_out(stretch, at):
        return None
    far = wide.split(at - begin)
    if far.chi2(far.polished(size)) < _FOLLOWED * far.y.size:
        return _judged(far, far.polished(size), wide.time[at - begin], stretch.sd, at)
    parts = seen.split(at - first)
    return _judged(parts, parts.polished(size), seen.time[at - first], stretch.sd, at)


def _stands_out(stretch: Stretch, at: int) -> bool:
    """The misfit of the window is far above that of its neighbours: a second mode is all along, a loss is not."""
    seen, first = window(stretch, at, _SCALES[-1] * stretch.periods)
    here, width = _misfit(seen, at - first), seen.time.size
    beside = []
    for place in (at - width, at + width):
        if 0.5 * width < place < stretch.samples.shape[1] - 0.5 * width:
            other, begin = window(stretch, place, _SCALES[-1] * stretch.periods)
            beside.append(_misfit(other, place - begin))
    return not beside or here > _OUT * min(beside)


def _misfit(seen: Window, at: int) -> float:
    """chi^2 of waves without a loss, beyond what noise gives."""
    parts = seen.split(at)
    return max(0.0, parts.chi2(0.0) - parts.y.size)


def _size(wide: Blocks, near: Blocks) -> float:
    """The least loss that explains well; where waves do not follow a large swing for long, that of the short window."""
    size = wide.sizes()[0]
    if wide.chi2(size) < _FOLLOWED * wide.y.size:
        return size
    other = near.sizes()[0]
    return other if near.chi2(other) < _FOLLOWED * near.y.size else size


def _begun(stretch: Stretch, near: int) -> int:
    """Where to look first: a place that is missed by a tenth of a period hides the size of a loss."""
    reach = 1.0 / stretch.frequency(float(near))
    found: dict[int, float] = {}
    for at in {round(near + share * reach) for share in _BESIDE}:
        wide, begin = window(stretch, at, stretch.periods)
        if 0 < at - begin < wide.time.size:
            parts = wide.split(at - begin)
            found[at] = min(parts.chi2(s) for s in parts.sizes())
    return min(found, key=lambda at: found[at], default=near)


def _judged(parts: Blocks, size: float, place: float, scale: Array, at: int) -> PhaseStep | None:
    """The step, if it is one; place: its time in the window, scale (channels,): the samples' unit."""
    whole, none = round(size), parts.chi2(0.0)
    inside, best = parts.fitted(float(whole))
    noise = max(best / (parts.y.size - inside.size), 1.0)
    curve = parts.chi2(size + 0.5) + parts.chi2(size - 0.5) - 2.0 * parts.chi2(size)
    sd = 0.5 * math.sqrt(2.0 * noise / max(curve, 1e-300))
    left = max(best - parts.y.size, 0.0)
    sure = whole >= 1 and abs(size - whole) < max(_WHOLE, 5.0 * sd) and sd < min(0.5, size / _SEEN)
    if not sure or none - best < _EXPLAINED * (none - best + left) or parts.kicked() - best < _KICK * noise:
        return None
    rows, _ = waves(place + np.arange(whole, dtype=np.float64), parts.frequency, parts.half)
    log_p = log_chance((none - best) / noise, 2, 1e6)
    return PhaseStep(at, whole, size, sd, log_p, np.asarray((inside @ rows) * scale[:, None]))
