"""Defects of the data themselves: gaps in the clock, saturation, duplicated shots."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.linearised_shot import LinearisedShot
from platform_daemon.diagnosis.regression.per_shot_fit import per_shot_fit
from platform_daemon.diagnosis.report_schema import DefectKind
from platform_daemon.diagnosis.shots.kicked_motion import motion_basis
from platform_daemon.diagnosis.shots.shot import DiagnosisShot, PreparedShot, whitening_for
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError
from platform_daemon.estimation.screening.clipping import find_clipping, saturation

from .significance import log_chance

_LIMITS = THRESHOLDS.selection
_NO_STRENGTHS = np.zeros(0)  # of the declared model alone


@dataclass(frozen=True, kw_only=True)
class DataDefect:
    """A defect of the recorded data.

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
            found.append(DataDefect(id="saturation", where=f"{shot.name}: {clipped}", shot=k))
        key = shot.record.samples.tobytes()
        if key in seen:
            found.append(
                DataDefect(
                    id="duplicated_shot", where=f"{shot.name} holds the samples of {shots[seen[key]].name}", shot=k
                )
            )
        else:
            seen[key] = k
    return found


def after_clipping(shot: DiagnosisShot, number: int) -> tuple[DiagnosisShot, list[DataDefect]]:
    """A shot of one angle from where its swing no longer reaches what it was cut off at, and what was left out.

    The swing dies down, so that the rest is as good as any other record.  Where little is left, and for other
    quantities, whose channels are clipped at other times, the shot is left as it is.
    """
    whole, found = shot, list[DataDefect]()
    while shot.record.quantity == "angle" and saturation(shot.record.valid, "angle") is not None:
        record, clipped = shot.record, find_clipping(shot.record.valid)
        assert clipped is not None  # that is what saturation found
        outwards = record.valid[0] if clipped.side == "top" else -record.valid[0]
        first = record.valid_from + 1 + int(np.flatnonzero(outwards == outwards.max())[-1])
        if record.end - first < _LIMITS.unclipped_share * whole.record.samples.shape[1]:
            return whole, []
        left = replace(record, valid_from=first)
        where = f"{shot.name}: {clipped}; the swing is followed from sample {first} on, at {first * record.dt_s:.4g} s"
        found.append(DataDefect(id="saturation", where=where, shot=number))
        noise = estimate_noise(left) if shot.noise.of_swings else shot.noise
        shot = replace(shot, record=left, noise=noise)
    return shot, found


def likeliest_jump(prepared: PreparedShot, hypothesis: Hypothesis) -> bool:
    """True if the phase seems to jump somewhere in a shot's own fit; a missing effect may look like that too."""
    try:
        return _strongest(per_shot_fit(prepared, hypothesis, _NO_STRENGTHS)[0]) is not None
    except LostTrajectoryError:
        return False


def gap_filled(
    prepared: Sequence[PreparedShot], model: RingDownModel, pool: Executor, known: Sequence[DataDefect] = ()
) -> tuple[list[PreparedShot], list[DataDefect]]:
    """Shots whose clock gaps are filled with samples, and these gaps.

    known: gaps that were filled before, perhaps with a few samples too many.
    """

    def one(pair: tuple[int, PreparedShot]) -> tuple[PreparedShot, list[DataDefect]]:
        places = {f.at: round(f.value or 0.0) for f in known if f.shot == pair[0] and f.at is not None}
        return _gap_filled(*pair, model, places)

    results = list(pool.map(one, enumerate(prepared)))
    return [r[0] for r in results], [f for r in results for f in r[1]]


def merged(gaps: Sequence[DataDefect]) -> list[DataDefect]:
    """Gaps of one shot at one place merged into one: its first filling and later corrections."""
    found: dict[tuple[int, int | None], DataDefect] = {}
    for gap in gaps:
        first = found.get((gap.shot, gap.at))
        if first is not None:
            size = round(first.value or 0.0) + (gap.value or 0.0)
            where = gap_in_words(first.where.split(":")[0], round(size), gap.at)
            gap = replace(gap, value=size, where=where, log_p=min(first.log_p, gap.log_p))
        found[gap.shot, gap.at] = gap
    return list(found.values())


def gap_in_words(name: str, samples: int, at: int | None) -> str:
    """Of a shot by its name; samples: how many are missing, negative if they are repeated."""
    if samples < 0:
        return f"{name}: {-samples} samples stand twice, again from sample {at} on"
    return f"{name}: {samples} samples are missing before sample {at}"


def _known_place(at: int, samples: int, places: Mapping[int, int], reach: float) -> int | None:
    """Place of a known gap close by that has at least as many samples as are to be removed."""
    near = [p for p, count in places.items() if abs(p - at) < reach and count + samples >= 1]
    return min(near, key=lambda p: abs(p - at), default=None)


def _gap_filled(
    k: int, prepared: PreparedShot, model: RingDownModel, places: Mapping[int, int]
) -> tuple[PreparedShot, list[DataDefect]]:
    """Gap after gap, each with a new fit."""
    found: list[DataDefect] = []
    hypothesis = Hypothesis(model)
    try:
        linear, state = per_shot_fit(prepared, hypothesis, _NO_STRENGTHS)
    except LostTrajectoryError:
        return prepared, found
    while len(found) < _LIMITS.most_gaps:
        place = _strongest(linear)
        # If the model does not follow the motion, any misfit of the phase looks like a gap.
        if place is None or linear.chi2 - (place[2] / place[3]) ** 2 > _LIMITS.gap_chi2_per_dof * prepared.dof:
            break
        log_p, index, _, _ = place
        at, there, there_sd = _located(prepared, model, state, index)
        step, sd = _size(linear, prepared, at)
        samples = round(step)
        known = _known_place(
            at, samples, places, _LIMITS.known_gap_periods * prepared.shot.rate_hz * 2.0 * math.pi / state.dynamics.w
        )
        whole = (samples >= 1 or (samples and known is not None)) and abs(step - samples) < max(
            _LIMITS.gap_whole_share * abs(samples), _LIMITS.whole_sigma * sd
        )
        # A torque bends the phase slowly; a gap steps it at one place.
        if not (whole and abs(there - step) < _LIMITS.whole_sigma * there_sd + _LIMITS.gap_whole_share * abs(samples)):
            break
        at = at if known is None else known
        places = {**places, at: places.get(at, 0) + samples}
        prepared = _filled(prepared, at, samples)
        linear, state = per_shot_fit(replace(prepared, state=state), hypothesis, _NO_STRENGTHS)
        prepared = replace(prepared, state=state)
        where = gap_in_words(prepared.shot.name, samples, at)
        found.append(DataDefect(id="clock_gap", where=where, shot=k, at=at, value=step, sd=sd, log_p=log_p))
    return prepared, found


def _strongest(linear: LinearisedShot) -> tuple[float, int, float, float] | None:
    """(log of its chance, index of the instant, step in s, its sd) of the likeliest jump of time; None: no jump."""
    prepared = linear.linearisation.prepared
    slope = prepared.white(linear.linearisation.slope[None]).reshape(linear.linearisation.slope.shape)
    residual = linear.without_own(linear.residual).reshape(slope.shape)
    channels, m = linear.linearisation.slope.shape
    q = np.concatenate([linear.own, linear.q], axis=1).reshape(channels, m, -1)
    after = np.einsum("cm,cmp->mp", slope, q)[::-1].cumsum(axis=0)[::-1]
    power = np.sum(slope**2, axis=0)[::-1].cumsum()[::-1]
    gradient = np.sum(slope * residual, axis=0)[::-1].cumsum()[::-1]
    information = power - np.sum(after**2, axis=1)
    # A jump at the very ends is no jump.
    usable = information > _LIMITS.gap_seen_share * power[0]
    if not usable.any():
        return None
    factor = max(1.0, linear.chi2 / prepared.dof)
    gain = np.where(usable, gradient**2 / np.where(usable, information, 1.0), 0.0) / factor
    best = int(np.argmax(gain))
    log_p = log_chance(float(gain[best]), 1, m)
    if log_p > _LIMITS.gap_log_p:
        return None
    return log_p, best, float(gradient[best] / information[best]), float(information[best] ** -0.5)


def _located(prepared: PreparedShot, model: RingDownModel, state: FitState, index: int) -> tuple[int, float, float]:
    """(first sample after the jump, its size in samples, standard deviation) from the samples around an instant."""
    time, rate = prepared.time_s, prepared.shot.rate_hz
    first = int(time[max(0, index - _LIMITS.gap_reach)] * rate)
    last = min(
        prepared.shot.record.samples.shape[1], int(time[min(time.size - 1, index + _LIMITS.gap_reach)] * rate) + 1
    )
    d, obs = state.dynamics, state.observation
    basis, steepness = motion_basis(model, state, first, last, 1.0 / rate, obs.observable)
    gains = obs.gains(d.w)
    residual = prepared.shot.record.samples[:, first:last] - gains @ basis[:2] - state.offsets[:, None]
    slope = d.w * gains @ steepness
    # Before and after the jump the residual is a multiple of the slope, with different factors.
    scale = prepared.white.scale[:, :1]
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


def _size(linear: LinearisedShot, prepared: PreparedShot, at: int) -> tuple[float, float]:
    """Samples lost before sample `at`, and their standard deviation."""
    later = prepared.time_s * prepared.shot.rate_hz >= at - 0.5
    column = linear.linearisation.slope * later / prepared.shot.rate_hz
    rest = linear.without_own(prepared.white(column[None])[0])
    power = float(rest @ rest)
    factor = max(1.0, linear.chi2 / prepared.dof)
    return float(rest @ linear.residual) / power, (factor / power) ** 0.5


def _filled(prepared: PreparedShot, at: int, count: int) -> PreparedShot:
    """The shot with samples put in before sample `at`, on a cubic through their neighbours; or with fewer."""
    y = prepared.shot.record.samples
    if count < 0:
        late = y[:, -1:] + (y[:, -1:] - y[:, -2:-1]) * np.arange(1, 1 - count)
        return _with(prepared, np.concatenate([y[:, :at], y[:, at - count :], late], axis=1))
    reach = _LIMITS.cubic_reach
    around = np.concatenate([np.arange(-reach, 0), np.arange(count, count + reach)])
    which = np.clip(np.arange(at - reach, at + reach), 0, y.shape[1] - 1)
    cubic = np.polynomial.polynomial.polyfit(around, y[:, which].T, 3)
    new = np.polynomial.polynomial.polyval(np.arange(count), cubic)
    new = new.reshape(y.shape[0], count)
    return _with(prepared, np.concatenate([y[:, :at], new, y[:, at:]], axis=1)[:, : y.shape[1]])


def _with(prepared: PreparedShot, samples: Array) -> PreparedShot:
    """The shot with other samples, as many as before."""
    record = replace(prepared.shot.record, samples=samples)
    # A step of the phase spreads over the spectrum: noise measured in other bands contains some of it.
    noise = prepared.shot.noise if "blank" in prepared.shot.noise.source else estimate_noise(record)
    shot = replace(prepared.shot, record=record, noise=noise)
    white = whitening_for(shot, prepared.grids, prepared.state.dynamics.w / (2.0 * math.pi))
    return PreparedShot(shot, prepared.state, prepared.grids, white)
