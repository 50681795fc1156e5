"""Clock gaps that the samples themselves show are filled, and repeated samples left out, without a model of motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np
from scipy.signal import medfilt

from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.shot import DiagnosisShot, PreparedShot
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.noise.coloured import sd_at
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError
from platform_daemon.estimation.physics.trajectory.turning_points import turning_points
from platform_daemon.estimation.screening.angle_cycles import find_half_cycles
from platform_daemon.estimation.screening.oscillation import find_oscillation

from .data_integrity import DataDefect, gap_in_words, likeliest_jump
from .local_swing import Stretch
from .phase_steps import PhaseStep, lost_samples

_LIMITS = THRESHOLDS.selection


def filled_angles(shots: Sequence[DiagnosisShot], pool: Executor) -> tuple[list[DiagnosisShot], list[DataDefect]]:
    """Angle records with their gaps filled, and these gaps; no model of the motion is needed."""
    results = list(pool.map(lambda pair: _filled(pair[0], pair[1], _frequency_of_angle), enumerate(shots)))
    return [r[0] for r in results], [f for r in results for f in r[1]]


def filled_dipoles(
    prepared: Sequence[PreparedShot], model: RingDownModel, pool: Executor
) -> tuple[list[PreparedShot], list[DataDefect]]:
    """Shots of dm/dt with their gaps filled and fitted again; only shots whose phase seems to jump are searched."""

    def one(pair: tuple[int, PreparedShot]) -> tuple[PreparedShot, list[DataDefect]]:
        k, shot = pair
        if not likeliest_jump(shot, Hypothesis(model)):
            return shot, []
        turns = _frequency_of_motion(shot, model)
        mended, found = _filled(k, shot.shot, lambda _: turns, _LIMITS.dipole_window_periods, _LIMITS.dipole_points)
        again = initial_fits([mended], model, pool=None)[0] if found else []
        return (again[0], found) if again else (shot, [])

    results = list(pool.map(one, enumerate(prepared)))
    return [r[0] for r in results], [f for r in results for f in r[1]]


Frequency = Callable[[float], float]


def _filled(
    k: int,
    shot: DiagnosisShot,
    frequency: Callable[[DiagnosisShot], Frequency | None],
    periods: float = _LIMITS.angle_window_periods,
    points: int = _LIMITS.angle_points,
) -> tuple[DiagnosisShot, list[DataDefect]]:
    """One shot with its gaps filled, and these gaps."""
    found: list[DataDefect] = []
    for _ in range(_LIMITS.most_gap_passes):
        local = frequency(shot)
        steps = [] if local is None else _losses(shot, local, periods, points)
        if not steps:
            break
        for step in reversed(steps):
            shot = _with_samples(shot, step)
            where = gap_in_words(shot.name, step.samples, step.at)
            found.append(
                DataDefect(
                    id="clock_gap", where=where, shot=k, at=step.at, value=step.size, sd=step.sd, log_p=step.log_p
                )
            )
    return shot, found


def _losses(shot: DiagnosisShot, local: Frequency, periods: float, points: int) -> list[PhaseStep]:
    """Gaps of a shot, counted from its first sample."""
    first = shot.record.valid_from
    level = sd_at(shot.noise, np.array([local(0.0) * shot.rate_hz]), shot.rate_hz)[:, 0]
    samples = shot.record.samples[:, first : shot.record.end]
    steps = lost_samples(
        Stretch(samples=samples, sd=level, frequency=lambda at: local(at + first), periods=periods, points=points)
    )
    return [replace(s, at=s.at + first) for s in steps]


def _with_samples(shot: DiagnosisShot, step: PhaseStep) -> DiagnosisShot:
    """The shot with the missing samples inserted, cut to its former length; or without the repeated ones, shorter."""
    y, at, repeated = shot.record.samples, step.at, max(-step.samples, 0)
    samples = np.concatenate([y[:, :at], step.filled, y[:, at + repeated :]], axis=1)[:, : y.shape[1]]
    record = replace(shot.record, samples=samples, valid_to=shot.record.end - repeated)
    # A step of the phase spreads over the spectrum: noise measured in other bands contains some of it.
    noise = shot.noise if "blank" in shot.noise.source else estimate_noise(record)
    return replace(shot, record=record, noise=noise)


def _frequency_of_angle(shot: DiagnosisShot) -> Frequency | None:
    """Of its half cycles, in cycles per sample."""
    record = shot.record
    line = find_oscillation(record)
    if line is None:
        return None
    samples = record.samples[0, record.valid_from : record.end]
    cycles = find_half_cycles(samples, first=record.valid_from, dt_s=record.dt_s, frequency_hz=line.frequency_hz)
    if cycles is None or cycles.passages_s.size < _LIMITS.smoothed_half_cycles:
        return None
    return _interpolated(cycles.passages_s, record.sampling_rate_hz)


def _frequency_of_motion(prepared: PreparedShot, model: RingDownModel) -> Frequency | None:
    """Of a fitted motion's turning points."""
    record = prepared.shot.record
    try:
        times, _ = turning_points(model, prepared.state.dynamics, record.end * record.dt_s)
    except LostTrajectoryError:
        return None
    return (
        _interpolated(np.asarray(times), record.sampling_rate_hz)
        if len(times) >= _LIMITS.smoothed_half_cycles
        else None
    )


def _interpolated(passages_s: Array, rate_hz: float) -> Frequency:
    """Local frequency from instants half a period apart; the median removes the outlier that a gap makes."""
    middle = 0.5 * (passages_s[1:] + passages_s[:-1]) * rate_hz
    local = 0.5 / (np.diff(passages_s) * rate_hz)
    if local.size >= _LIMITS.smoothed_half_cycles:
        local = medfilt(local, _LIMITS.smoothed_half_cycles)
        local[:2], local[-2:] = (
            np.median(local[: _LIMITS.smoothed_half_cycles]),
            np.median(local[-_LIMITS.smoothed_half_cycles :]),
        )
    return lambda at: float(np.interp(at, middle, local))
