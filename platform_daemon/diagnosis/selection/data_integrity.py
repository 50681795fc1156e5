"""What is wrong with the data themselves, before any physics is asked: gaps in the clock, saturation, copies."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.estimation import (
    Array,
    FitState,
    LostTrajectoryError,
    RingDownModel,
    Workspace,
    estimate_noise,
    saturation,
)
from platform_daemon.schemas import DefectKind

from ..regression.hypothesis import Hypothesis
from ..regression.linearised_shot import LinearisedShot
from ..regression.own_fit import own_fit
from ..shots.shot import DiagnosisShot, PreparedShot, whitening_for
from .significance import log_chance

_NOTHING = np.zeros(0)  # strengths of the declared model alone
_SURE = -18.0  # logarithm of the chance of a gap in a clock without one
_MOST_GAPS = 4
_FOLLOWED = 3.0  # chi^2 per degree of freedom of a model that misses no more than some lost samples
_WHOLE = 0.15  # share by which a gap may miss a whole number of samples
_AROUND = 4  # instants on either side in which a gap is located


@dataclass(frozen=True)
class DataDefect:
    """Something that is not as it should be.

    Attributes:
        id: kind of the defect; where: in words.
        shot: its number; samples, at, value, sd: of a gap.
    """

    id: DefectKind
    where: str
    shot: int
    at: int | None = None
    value: float | None = None
    sd: float | None = None
    log_p: float = 0.0


def data_defects(shots: Sequence[DiagnosisShot]) -> list[DataDefect]:
    """Saturated and duplicated shots."""
    found = []
    seen: dict[bytes, int] = {}
    for k, shot in enumerate(shots):
        clipped = saturation(shot.record.valid, shot.record.quantity)
        if clipped is not None:
            found.append(DataDefect("saturation", f"{shot.name}: {clipped}", k))
        key = shot.record.samples.tobytes()
        if key in seen:
            found.append(DataDefect("duplicated_shot", f"{shot.name} holds the samples of {shots[seen[key]].name}", k))
        else:
            seen[key] = k
    return found


def likeliest_jump(started: PreparedShot, hypothesis: Hypothesis) -> bool:
    """True if the phase of a shot's own fit seems to jump somewhere; what a model lacks may look like that too."""
    try:
        return _strongest(own_fit(started, hypothesis, _NOTHING)[0]) is not None
    except LostTrajectoryError:
        return False


def without_gaps(
    started: Sequence[PreparedShot], model: RingDownModel, pool: Executor, known: Sequence[DataDefect] = ()
) -> tuple[list[PreparedShot], list[DataDefect]]:
    """Shots with the samples put back that their clocks have lost, and where that was.

    known: losses that were put back already; of these a few samples may be too many.
    """

    def one(pair: tuple[int, PreparedShot]) -> tuple[PreparedShot, list[DataDefect]]:
        places = {f.at: round(f.value or 0.0) for f in known if f.shot == pair[0] and f.at is not None}
        return _mended(*pair, model, places)

    results = list(pool.map(one, enumerate(started)))
    return [r[0] for r in results], [f for r in results for f in r[1]]


def merged(gaps: Sequence[DataDefect]) -> list[DataDefect]:
    """Losses of one shot at one place as one: what was put back first, and what was missing or too much then."""
    found: dict[tuple[int, int | None], DataDefect] = {}
    for gap in gaps:
        first = found.get((gap.shot, gap.at))
        if first is not None:
            size = round(first.value or 0.0) + (gap.value or 0.0)
            where = f"{first.where.split(':')[0]}: {round(size)} samples are missing before sample {gap.at}"
            gap = replace(gap, value=size, where=where, log_p=min(first.log_p, gap.log_p))
        found[gap.shot, gap.at] = gap
    return list(found.values())


def _known_place(at: int, samples: int, places: Mapping[int, int], reach: float) -> int | None:
    """Where samples were put back close by, more of them than are now too many."""
    near = [p for p, count in places.items() if abs(p - at) < reach and count + samples >= 1]
    return min(near, key=lambda p: abs(p - at), default=None)


def _mended(
    k: int, started: PreparedShot, model: RingDownModel, places: Mapping[int, int]
) -> tuple[PreparedShot, list[DataDefect]]:
    """Gap after gap, each with a new fit."""
    found: list[DataDefect] = []
    hypothesis = Hypothesis(model)
    try:
        linear, state = own_fit(started, hypothesis, _NOTHING)
    except LostTrajectoryError:
        return started, found
    while len(found) < _MOST_GAPS:
        place = _strongest(linear)
        # Beside a model that does not follow the motion any misfit of the phase looks like a loss.
        if place is None or linear.chi2 - (place[2] / place[3]) ** 2 > _FOLLOWED * started.dof:
            break
        log_p, index, _, _ = place
        at, there, there_sd = _located(started, model, state, index)
        step, sd = _size(linear, started, at)
        samples = round(step)
        known = _known_place(at, samples, places, 0.25 * started.shot.rate_hz * 2.0 * math.pi / state.dynamics.w)
        whole = (samples >= 1 or (samples and known is not None)) and abs(step - samples) < max(
            _WHOLE * abs(samples), 5.0 * sd
        )
        # A torque bends the phase slowly; a gap steps it at one place.
        if not (whole and abs(there - step) < 5.0 * there_sd + _WHOLE * abs(samples)):
            break
        at = at if known is None else known
        places = {**places, at: places.get(at, 0) + samples}
        started = _filled(started, at, samples)
        linear, state = own_fit(replace(started, state=state), hypothesis, _NOTHING)
        started = replace(started, state=state)
        where = f"{started.shot.name}: {samples} samples are missing before sample {at}"
        found.append(DataDefect("clock_gap", where, k, at, step, sd, log_p))
    return started, found


def _strongest(linear: LinearisedShot) -> tuple[float, int, float, float] | None:
    """(log of its chance, index of the instant, step in s, its sd) of the likeliest jump of time; None: no jump."""
    started = linear.seen.started
    slope = started.white(linear.seen.slope[None]).reshape(linear.seen.slope.shape)
    residual = linear.beside(linear.residual).reshape(slope.shape)
    channels, m = linear.seen.slope.shape
    q = np.concatenate([linear.own, linear.q], axis=1).reshape(channels, m, -1)
    after = np.einsum("cm,cmp->mp", slope, q)[::-1].cumsum(axis=0)[::-1]
    power = np.sum(slope**2, axis=0)[::-1].cumsum()[::-1]
    gradient = np.sum(slope * residual, axis=0)[::-1].cumsum()[::-1]
    information = power - np.sum(after**2, axis=1)
    # A jump at the very ends is no jump.
    usable = information > 1e-6 * power[0]
    if not usable.any():
        return None
    factor = max(1.0, linear.chi2 / started.dof)
    gain = np.where(usable, gradient**2 / np.where(usable, information, 1.0), 0.0) / factor
    best = int(np.argmax(gain))
    log_p = log_chance(float(gain[best]), 1, m)
    if log_p > _SURE:
        return None
    return log_p, best, float(gradient[best] / information[best]), float(information[best] ** -0.5)


def _located(started: PreparedShot, model: RingDownModel, state: FitState, index: int) -> tuple[int, float, float]:
    """(first sample after the jump, its size in samples, standard deviation) from the samples around an instant."""
    time, rate = started.time_s, started.shot.rate_hz
    first = int(time[max(0, index - _AROUND)] * rate)
    last = min(started.shot.record.samples.shape[1], int(time[min(time.size - 1, index + _AROUND)] * rate) + 1)
    d, obs = state.dynamics, state.observation
    basis = Workspace(model).basis(d, first, last, 1.0 / rate, obs.observable)
    gains = obs.gains(d.w)
    residual = started.shot.record.samples[:, first:last] - gains @ basis[:2] - state.offsets[:, None]
    slope = d.w * gains @ basis[2:4]
    # Before and after the jump the residual is a multiple of the slope, with different factors.
    scale = started.white.scale[:, :1]
    r, s = residual * scale, slope * scale
    split, step, sd = _best_split(np.sum(r * s, axis=0), np.sum(s * s, axis=0))
    return first + split, step * rate, sd * rate


def _best_split(cross: Array, power: Array) -> tuple[int, float, float]:
    """Where two factors, one before and one after, explain most; their difference and its standard deviation."""
    before, before2 = cross.cumsum(), power.cumsum()
    after, after2 = before[-1] - before, before2[-1] - before2
    explained = before[:-1] ** 2 / np.maximum(before2[:-1], 1e-300) + after[:-1] ** 2 / np.maximum(after2[:-1], 1e-300)
    k = int(np.argmax(explained))
    step = after[k] / max(after2[k], 1e-300) - before[k] / max(before2[k], 1e-300)
    return k + 1, float(step), float(np.sqrt(1.0 / max(after2[k], 1e-300) + 1.0 / max(before2[k], 1e-300)))


def _size(linear: LinearisedShot, started: PreparedShot, at: int) -> tuple[float, float]:
    """Samples lost before sample `at`, and their standard deviation."""
    later = started.time_s * started.shot.rate_hz >= at - 0.5
    column = linear.seen.slope * later / started.shot.rate_hz
    rest = linear.beside(started.white(column[None])[0])
    power = float(rest @ rest)
    factor = max(1.0, linear.chi2 / started.dof)
    return float(rest @ linear.residual) / power, (factor / power) ** 0.5


def _filled(started: PreparedShot, at: int, count: int) -> PreparedShot:
    """The shot with samples put in before sample `at`, on a cubic through their neighbours; or with fewer."""
    y = started.shot.record.samples
    if count < 0:
        late = y[:, -1:] + (y[:, -1:] - y[:, -2:-1]) * np.arange(1, 1 - count)
        return _with(started, np.concatenate([y[:, :at], y[:, at - count :], late], axis=1))
    around = np.concatenate([np.arange(-4, 0), np.arange(count, count + 4)])
    which = np.clip(np.concatenate([np.arange(at - 4, at), np.arange(at, at + 4)]), 0, y.shape[1] - 1)
    cubic = np.polynomial.polynomial.polyfit(around, y[:, which].T, 3)
    new = np.polynomial.polynomial.polyval(np.arange(count), cubic)
    new = new.reshape(y.shape[0], count)
    return _with(started, np.concatenate([y[:, :at], new, y[:, at:]], axis=1)[:, : y.shape[1]])


def _with(started: PreparedShot, samples: Array) -> PreparedShot:
    """The shot with other samples, as many as before."""
    record = replace(started.shot.record, samples=samples)
    # A step of the phase spreads over the spectrum: noise that was measured beside the signal held some of it.
    noise = started.shot.noise if "blank" in started.shot.noise.source else estimate_noise(record)
    shot = replace(started.shot, record=record, noise=noise)
    white = whitening_for(shot, started.grids, started.state.dynamics.w / (2.0 * math.pi))
    return PreparedShot(shot, started.state, started.grids, white)
