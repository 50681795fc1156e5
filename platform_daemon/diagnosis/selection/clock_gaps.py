"""Samples that clocks have lost are put back: first those that the samples themselves show, then what physics shows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np
from scipy.signal import medfilt

from platform_daemon.estimation import (
    Array,
    LostTrajectoryError,
    RingDownModel,
    estimate_noise,
    find_half_cycles,
    find_oscillation,
    sd_at,
    turning_points,
)

from ..regression.hypothesis import Hypothesis
from ..shots.initial_fits import initial_fits
from ..shots.shot import DiagnosisShot, PreparedShot
from .data_integrity import DataDefect, likeliest_jump
from .local_swing import Stretch
from .phase_steps import PhaseStep, lost_samples

_MOST_PASSES = 3  # a loss may hide another one beside it
_ANGLE_PERIODS, _DIPOLE_PERIODS = 1.5, 6.0  # half of a window: as long as noise asks for, as short as the swing changes
_ANGLE_POINTS, _DIPOLE_POINTS = 40, 16  # per period
_SMOOTHED = 5  # half cycles


def filled_angles(shots: Sequence[DiagnosisShot], pool: Executor) -> tuple[list[DiagnosisShot], list[DataDefect]]:
    """Angle records with what they have lost, and where that was; whatever their motion is."""
    results = list(pool.map(lambda pair: _filled(pair[0], pair[1], _frequency_of_angle), enumerate(shots)))
    return [r[0] for r in results], [f for r in results for f in r[1]]


def filled_dipoles(
    started: Sequence[PreparedShot], model: RingDownModel, pool: Executor
) -> tuple[list[PreparedShot], list[DataDefect]]:
    """Shots of dm/dt with what they have lost, fitted again; only those are searched that seem to have a jump."""

    def one(pair: tuple[int, PreparedShot]) -> tuple[PreparedShot, list[DataDefect]]:
        k, shot = pair
        if not likeliest_jump(shot, Hypothesis(model)):
            return shot, []
        turns = _frequency_of_motion(shot, model)
        mended, found = _filled(k, shot.shot, lambda _: turns, _DIPOLE_PERIODS, _DIPOLE_POINTS)
        again = initial_fits([mended], model, pool=None)[0] if found else []
        return (again[0], found) if again else (shot, [])

    results = list(pool.map(one, enumerate(started)))
    return [r[0] for r in results], [f for r in results for f in r[1]]


Frequency = Callable[[float], float]


def _filled(
    k: int,
    shot: DiagnosisShot,
    frequency: Callable[[DiagnosisShot], Frequency | None],
    periods: float = _ANGLE_PERIODS,
    points: int = _ANGLE_POINTS,
) -> tuple[DiagnosisShot, list[DataDefect]]:
    """One shot with what it has lost put back, and where that was."""
    found: list[DataDefect] = []
    for _ in range(_MOST_PASSES):
        local = frequency(shot)
        steps = [] if local is None else _losses(shot, local, periods, points)
        if not steps:
            break
        for step in reversed(steps):
            shot = _with_samples(shot, step)
            where = f"{shot.name}: {step.samples} samples are missing before sample {step.at}"
            found.append(DataDefect("clock_gap", where, k, step.at, step.size, step.sd, step.log_p))
    return shot, found


def _losses(shot: DiagnosisShot, local: Frequency, periods: float, points: int) -> list[PhaseStep]:
    """What a shot has lost, counted from its first sample."""
    first = shot.record.valid_from
    level = sd_at(shot.noise, np.array([local(0.0) * shot.rate_hz]), shot.rate_hz)[:, 0]
    seen = shot.record.samples[:, first : shot.record.end]
    steps = lost_samples(Stretch(seen, level, lambda at: local(at + first), periods, points))
    return [replace(s, at=s.at + first) for s in steps]


def _with_samples(shot: DiagnosisShot, step: PhaseStep) -> DiagnosisShot:
    """The shot with what is missing put in; as long as before."""
    y, at = shot.record.samples, step.at
    samples = np.concatenate([y[:, :at], step.filled, y[:, at:]], axis=1)[:, : y.shape[1]]
    record = replace(shot.record, samples=samples)
    # A step of the phase spreads over the spectrum: noise that was measured beside the signal held some of it.
    noise = shot.noise if "blank" in shot.noise.source else estimate_noise(record)
    return replace(shot, record=record, noise=noise)


def _frequency_of_angle(shot: DiagnosisShot) -> Frequency | None:
    """Of its half cycles, in cycles per sample."""
    record = shot.record
    line = find_oscillation(record)
    if line is None:
        return None
    seen = record.samples[0, record.valid_from : record.end]
    cycles = find_half_cycles(seen, record.valid_from, record.dt_s, line.frequency_hz)
    if cycles is None or cycles.passages_s.size < _SMOOTHED:
        return None
    return _interpolated(cycles.passages_s, record.sampling_rate_hz)


def _frequency_of_motion(started: PreparedShot, model: RingDownModel) -> Frequency | None:
    """Of a fitted motion's turning points."""
    record = started.shot.record
    try:
        times, _ = turning_points(model, started.state.dynamics, record.end * record.dt_s)
    except LostTrajectoryError:
        return None
    return _interpolated(np.asarray(times), record.sampling_rate_hz) if len(times) >= _SMOOTHED else None


def _interpolated(passages_s: Array, rate_hz: float) -> Frequency:
    """Local frequency from instants half a period apart; a loss between two of them is one that stands out."""
    middle = 0.5 * (passages_s[1:] + passages_s[:-1]) * rate_hz
    local = 0.5 / (np.diff(passages_s) * rate_hz)
    if local.size >= _SMOOTHED:
        local = medfilt(local, _SMOOTHED)
        local[:2], local[-2:] = np.median(local[:_SMOOTHED]), np.median(local[-_SMOOTHED:])
    return lambda at: float(np.interp(at, middle, local))
