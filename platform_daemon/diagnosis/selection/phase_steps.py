"""Clock gaps in the samples themselves: the swing continues, but later than it should, or earlier.

In windows of few periods any swing is a sum of harmonics of slowly changing size, whatever its torques are. Where
samples are missing, what comes after is the same sum a whole number of samples later; where samples stand twice, as
many earlier. A torque bends the phase slowly; a kick turns it too, but leaves the angle where it was. No model of the
motion is needed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import irfft, rfft

from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array

from .local_swing import Blocks, Stretch, Window, block_means, waves, window
from .significance import log_chance

_LIMITS = THRESHOLDS.selection


@dataclass(frozen=True, kw_only=True)
class PhaseStep:
    """Lost samples, or repeated ones.

    Attributes:
        at: first sample after them, of repeated ones the first that stands there again.
        samples: how many, whole, negative if they are repeated; size, sd: as they were measured.
        log_p: logarithm of the chance of such a step by noise.
        filled: (channels, samples) what the swing would have shown there; none where samples are repeated.
    """

    at: int
    samples: int
    size: float
    sd: float
    log_p: float
    filled: Array


def lost_samples(stretch: Stretch) -> list[PhaseStep]:
    """Losses that are beyond doubt, in the order of time, no two of them within one window.

    Windows of several lengths are scanned over means of `block` samples, `points` of them per period; where one
    misfits (`suspects`: sample number -> log p), the loss is measured at the full rate, the most certain first.
    """
    block = max(1, int(1.0 / (stretch.frequency(0.0) * stretch.points)))
    means = block_means(stretch.samples, block) / stretch.sd[:, None] * math.sqrt(block)
    suspects: dict[int, float] = {}
    for share in _LIMITS.window_shares:
        windows = _scan(replace(stretch, periods=share * stretch.periods), means, block)
        suspects |= dict(_suspect(windows, means.shape[1], block * stretch.points))
    found: list[PhaseStep] = []
    for at in sorted(suspects, key=lambda at: suspects[at]):
        reach = 2.0 * stretch.periods / stretch.frequency(float(at))
        # Where the model misfits all along, every window is suspect: one look at the neighbours spares the measurement.
        if all(abs(at - f.at) > reach for f in found) and _may_stand_out(stretch, at):
            # Where a good part of a period is lost, a repeat may lead to a place where neither explains.
            step = _measured(stretch, at, repeated=True) or _measured(stretch, at, repeated=False)
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
    """(instant, logarithm of the chance) of suspects, one for each group of neighbours.

    A step by a good part of a period is none to first order: there the window as a whole is far from its like.
    """
    usual = float(np.median([w.misfit for w in windows])) if windows else 0.0
    sure = [w for w in windows if log_chance(w.gain, 1, float(count)) < _LIMITS.step_log_p]
    odd = [w for w in windows if w.misfit > _LIMITS.odd_ratio * max(usual, 1.0)]
    for at in _middles([w.at for w in odd], apart)[: _LIMITS.suspect_windows]:
        yield at, _LIMITS.step_log_p
    for some, size in ((odd, lambda w: w.misfit), (sure, lambda w: w.gain)):
        taken: list[int] = []
        for w in sorted(some, key=size, reverse=True):
            if len(taken) < _LIMITS.suspect_windows and all(abs(w.at - t) > apart for t in taken):
                taken.append(w.at)
                yield w.at, min(_LIMITS.step_log_p, log_chance(w.gain, 1, float(count)))


def _middles(places: Sequence[int], apart: int) -> list[int]:
    """Middles of runs of neighbouring places: a gap shows in every window that contains it."""
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
        rows, slopes = waves(time, math.exp(_LIMITS.alike_frequency_share * frequency), 0.5 * points)
        q = np.linalg.qr(rows.T)[0]
        # Derivatives of a window's fit, from its part within the waves.
        moved = np.linalg.lstsq(rows.T, q, rcond=None)[0].T @ slopes
        edge = _LIMITS.edge_points
        places = range(max(place, edge), min(place + _step(stretch), points - edge))
        if places:
            for k in range(0, len(firsts), _LIMITS.windows_in_memory):
                some = firsts[k : k + _LIMITS.windows_in_memory]
                y = np.stack([means[:, first : first + points] for first in some])
                gains, best, misfits = _best_in(y, q, moved, places)
                found += [
                    _Scanned(float(g), (first + int(at)) * block, float(m))
                    for first, g, at, m in zip(some, gains, best, misfits, strict=True)
                ]
    return sorted(found, key=lambda w: w.at)


def _step(stretch: Stretch) -> int:
    """From window to window, in points."""
    return max(1, int(stretch.points * stretch.periods) // _LIMITS.windows_per_width)


def _windows(stretch: Stretch, count: int, block: int) -> dict[tuple[int, int, int], list[int]]:
    """First points of the windows, by what they have in common: frequency in steps, points, first place of a step."""
    found: dict[tuple[int, int, int], list[int]] = {}
    for centre in range(0, count, _step(stretch)):
        frequency = stretch.frequency((centre + 0.5) * block) * block
        half = round(stretch.periods / frequency)
        first, last = max(0, centre - half), min(count, centre + half)
        if last - first > half:
            key = round(math.log(frequency) / _LIMITS.alike_frequency_share), last - first, centre - first
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
    power = np.maximum(whole - np.einsum("wkcq,wkcq->wk", within, within), _LIMITS.unseen_share * whole + 1e-300)
    fall = along**2 / power
    best = np.argmax(fall, axis=1)
    misfit = np.sum(left**2, axis=(1, 2)) / max(left[0].size - y.shape[1] * q.shape[1], 1)
    gain = fall[np.arange(y.shape[0]), best]
    for w in np.flatnonzero(gain > -_LIMITS.step_log_p):  # less is by chance, and most windows hold no more
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
    lags = irfft(np.sum(np.abs(rfft(rest, 2 * n, axis=1)) ** 2, axis=0), 2 * n)[: n // _LIMITS.lag_share]
    together = 2.0 * float(np.sum((lags / max(lags[0], 1e-300)) ** 2)) - 1.0
    return float(lags[0]) / (rest.shape[0] * max(n - fitted, 1)) * max(1.0, together - 0.5)


def _measured(stretch: Stretch, near: int, *, repeated: bool) -> PhaseStep | None:
    """The step near a sample, at every sample; None if it is none of whole samples, or a kick explains as much.

    The size comes from a long window, since a short one hardly excludes a gap that is a period longer; the place comes
    from a short one, where the waves follow any swing.
    """
    at = _first_place(stretch, near, repeated=repeated)
    for _ in range(_LIMITS.most_step_moves):
        wide, begin = window(stretch, at, stretch.periods)
        seen, first = window(stretch, at, _LIMITS.window_shares[-1] * stretch.periods)
        margin = _LIMITS.step_margin_periods / seen.frequency
        if not margin < at - first < seen.time.size - margin:
            return None
        size = _size(wide.split(at - begin), seen.split(at - first), repeated=repeated)
        there = first + seen.place(at - first, size)
        if there == at:
            break
        at = there
    if not _stands_out(stretch, at):
        return None
    far = wide.split(at - begin)
    if far.chi2(far.polished(size)) < _LIMITS.followed_chi2_per_value * far.y.size:
        return _judged(far, far.polished(size), wide.time[at - begin], stretch.sd, at)
    parts = seen.split(at - first)
    return _judged(parts, parts.polished(size), seen.time[at - first], stretch.sd, at)


def _may_stand_out(stretch: Stretch, near: int) -> bool:
    """Whether the misfit stands out at a sample or a period beside it, by less than at the place of the step itself."""
    period = round(1.0 / stretch.frequency(float(near)))
    places = (at for at in (near, near - period, near + period) if 0 < at < stretch.samples.shape[1])
    return any(_stands_out(stretch, at, _LIMITS.neighbour_hint_ratio) for at in places)


def _stands_out(stretch: Stretch, at: int, ratio: float = _LIMITS.neighbour_ratio) -> bool:
    """The misfit of the window is far above that of its neighbours: a second mode is all along, a loss is not."""
    seen, first = window(stretch, at, _LIMITS.window_shares[-1] * stretch.periods)
    here, width = _misfit(seen, at - first), seen.time.size
    neighbours = []
    for place in (at - width, at + width):
        if 0.5 * width < place < stretch.samples.shape[1] - 0.5 * width:
            other, begin = window(stretch, place, _LIMITS.window_shares[-1] * stretch.periods)
            neighbours.append(_misfit(other, place - begin))
    return not neighbours or here > ratio * min(neighbours)


def _misfit(seen: Window, at: int) -> float:
    """chi^2 of waves without a loss, beyond what noise gives."""
    parts = seen.split(at)
    return max(0.0, parts.chi2(0.0) - parts.y.size)


def _size(wide: Blocks, near: Blocks, *, repeated: bool) -> float:
    """The least loss that explains well; where waves do not follow a large swing for long, that of the short window."""
    size = wide.sizes(repeated=repeated)[0]
    if wide.chi2(size) < _LIMITS.followed_chi2_per_value * wide.y.size:
        return size
    other = near.sizes(repeated=repeated)[0]
    return other if near.chi2(other) < _LIMITS.followed_chi2_per_value * near.y.size else size


def _first_place(stretch: Stretch, near: int, *, repeated: bool) -> int:
    """The best start of the search near a sample: an error of a tenth of a period hides the size of a gap."""
    reach = 1.0 / stretch.frequency(float(near))
    found: dict[int, float] = {}
    for at in {round(near + share * reach) for share in _LIMITS.step_moves_periods}:
        wide, begin = window(stretch, at, stretch.periods)
        if 0 < at - begin < wide.time.size:
            parts = wide.split(at - begin)
            found[at] = min(parts.chi2(s) for s in parts.sizes(repeated=repeated))
    return min(found, key=lambda at: found[at], default=near)


def _judged(parts: Blocks, size: float, place: float, scale: Array, at: int) -> PhaseStep | None:
    """The step, if it is one; place: its time in the window, scale (channels,): the samples' unit."""
    whole, none = round(size), parts.chi2(0.0)
    inside, best = parts.fitted(float(whole))
    noise = max(best / (parts.y.size - inside.size), 1.0)
    curve = parts.chi2(size + 0.5) + parts.chi2(size - 0.5) - 2.0 * parts.chi2(size)
    sd = 0.5 * math.sqrt(2.0 * noise / max(curve, 1e-300))
    left = max(best - parts.y.size, 0.0)
    sure = (
        abs(whole) >= 1
        and abs(size - whole) < max(_LIMITS.step_whole_samples, _LIMITS.whole_sigma * sd)
        and sd < min(0.5, abs(size) / _LIMITS.step_seen_sigma)
    )
    if (
        not sure
        or none - best < _LIMITS.step_explained_share * (none - best + left)
        or parts.kicked() - best < _LIMITS.kick_chi2 * noise
    ):
        return None
    rows, _ = waves(place + np.arange(whole, dtype=np.float64), parts.frequency, parts.half)
    log_p = log_chance((none - best) / noise, 2, _LIMITS.step_trials)
    return PhaseStep(
        at=at, samples=whole, size=size, sd=sd, log_p=log_p, filled=np.asarray((inside @ rows) * scale[:, None])
    )
