"""From shots to fits of the declared model that later steps begin at, whatever the fit thinks of its residual."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.estimation import (
    DipoleObservation,
    FitState,
    FreeGainObservation,
    LostTrajectoryError,
    RefusedError,
    RingDownModel,
    RingDownRecord,
    by_convention,
    find_half_cycles,
    find_minimum,
    task_of,
    turning_points,
)

from .shot import DiagnosisShot, PreparedShot, grids_for, whitening_for

_LEFT = 0.12  # of the first amplitude: what is below says little and may be stuck
_FIRST_PART = 8  # of a window


@dataclass(frozen=True)
class UnfittedShot:
    """A shot that cannot be looked at, and why."""

    shot: DiagnosisShot
    reason: str


def initial_fits(
    shots: Sequence[DiagnosisShot], model: RingDownModel, pool: Executor | None
) -> tuple[list[PreparedShot], list[UnfittedShot]]:
    """Fit the declared model to every shot, down to 12 % of its amplitude or to the end of the record.

    pool: None: one after the other, in a thread of a pool for one.
    """
    results = list((map if pool is None else pool.map)(lambda shot: _start(shot, model), shots))
    started = [r for r in results if isinstance(r, PreparedShot)]
    return _on_one_side(started, model), [r for r in results if isinstance(r, UnfittedShot)]


def _on_one_side(started: Sequence[PreparedShot], model: RingDownModel) -> list[PreparedShot]:
    """Every shot as the twin (phi -> -phi) nearest to the first shot: common strengths and means need one side.

    Where e_v is perpendicular to x, noise decides which of the two a fit finds.
    """
    return [replace(s, state=_nearer_mirror_image(s.state, started[0].state, model)) for s in started]


def _nearer_mirror_image(state: FitState, reference: FitState, model: RingDownModel) -> FitState:
    """The state, or its twin if that is turned less against the reference."""
    here, there = state.observation, reference.observation
    if isinstance(here, FreeGainObservation) and isinstance(there, FreeGainObservation):
        same = np.sum(here.sensitivities[:, 0] * there.sensitivities[:, 0]) >= 0.0
        return state if same else replace(state.mirrored(model), observation=here.turned())
    if not (isinstance(here, DipoleObservation) and isinstance(there, DipoleObservation)):
        return state
    if np.sum(here.rotation[:, 1:] * there.rotation[:, 1:]) >= 0.0:
        return state
    return replace(state.mirrored(model), observation=here.turned())


def _start(shot: DiagnosisShot, model: RingDownModel) -> PreparedShot | UnfittedShot:
    try:
        state = by_convention(_minimum(shot, model), model)
        last = _end(shot, model, state)
    except (RefusedError, LostTrajectoryError) as error:
        return UnfittedShot(shot, str(error))
    frequency_hz = state.dynamics.w / (2.0 * math.pi)
    grids = grids_for(shot.record, last, frequency_hz)
    return PreparedShot(shot, state, grids, whitening_for(shot, grids, frequency_hz))


def _minimum(shot: DiagnosisShot, model: RingDownModel) -> FitState:
    """Of the whole window; where a model that lacks much finds none there, of an angle's first eighth.

    Raises RefusedError, LostTrajectoryError.
    """
    try:
        return find_minimum(task_of(shot.record, "d30", shot.noise, {}), model)[1].state
    except RefusedError:
        if shot.record.quantity != "angle":
            raise
        record = shot.record
        part = replace(record, valid_to=record.valid_from + (record.end - record.valid_from) // _FIRST_PART)
        return find_minimum(task_of(part, "d30", shot.noise, {}), model)[1].state


def _end(shot: DiagnosisShot, model: RingDownModel, state: FitState) -> int:
    """Sample at which the motion has become small."""
    record = shot.record
    if record.quantity == "angle":
        return _end_of_angle(record, state)
    times, sizes = turning_points(model, state.dynamics, record.end * record.dt_s)
    small = np.flatnonzero(sizes < _LEFT * abs(state.dynamics.amplitude))
    until_s = float(times[small[0]]) if small.size else float(times[-1])
    return min(record.end, max(record.valid_from, math.ceil(until_s * shot.rate_hz)))


def _end_of_angle(record: RingDownRecord, state: FitState) -> int:
    """The same as the samples themselves show it: friction that the model lacks may have stopped the swing long ago."""
    first = record.valid_from
    seen = record.samples[0, first : record.end]
    cycles = find_half_cycles(seen, first, record.dt_s, state.dynamics.w / (2.0 * math.pi))
    if cycles is None:
        return record.end
    sizes = np.abs(cycles.turning_rad)
    small = np.flatnonzero(sizes < _LEFT * sizes[0])
    if small.size:
        return min(record.end, math.ceil(float(cycles.turning_s[small[0]]) / record.dt_s))
    # Behind the last swing that stands out there is rest, or the end of the record.
    last_s = float(cycles.passages_s[-1]) + 0.5 * float(cycles.passages_s[-1] - cycles.passages_s[-2])
    return min(record.end, math.ceil(last_s / record.dt_s))
