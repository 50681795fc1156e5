"""Fits of the declared model to single shots, as starting points; the goodness of fit is not judged here."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.initial_guess.guess import observes_dipole
from platform_daemon.estimation.least_squares.constraints import fixed_values
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.least_squares.observation_model import DipoleObservation, FreeGainObservation
from platform_daemon.estimation.least_squares.public_parameters import by_convention
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.ring_down import dynamics_through
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError
from platform_daemon.estimation.physics.trajectory.state_at_zero import state_at_zero
from platform_daemon.estimation.physics.trajectory.turning_points import turning_points
from platform_daemon.estimation.prepared_record import prepare_record
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.refusal import Refusal, RefusedError
from platform_daemon.estimation.screening.angle_cycles import find_half_cycles
from platform_daemon.estimation.solve import find_minimum, find_minimum_coarsely

from .shot import DiagnosisShot, PreparedShot, grids_for, whitening_for

_LIMITS = THRESHOLDS.shots


@dataclass(frozen=True)
class UnfittedShot:
    """A shot that the declared model cannot be fitted to, and the reason."""

    shot: DiagnosisShot
    reason: str


def initial_fits(
    shots: Sequence[DiagnosisShot], model: RingDownModel, pool: Executor | None
) -> tuple[list[PreparedShot], list[UnfittedShot]]:
    """Fit the declared model to every shot, down to 12 % of its amplitude or to the end of the record.

    pool: None to fit one shot after the other in the calling thread.
    """
    results = list((map if pool is None else pool.map)(lambda shot: _start(shot, model), shots))
    prepared = [r for r in results if isinstance(r, PreparedShot)]
    return _on_one_side(prepared, model), [r for r in results if isinstance(r, UnfittedShot)]


def with_beginnings(
    prepared: Sequence[PreparedShot], refused: Sequence[UnfittedShot], model: RingDownModel
) -> tuple[list[PreparedShot], list[UnfittedShot]]:
    """Besides the fitted shots those of a known rotor that no single angle fits, by their first tenth of a second.

    A rotor with a manufacturing error may swing so that the whole window looks like two resonators.  Its beginning,
    fitted as if noise were a part of the signal, tells the frequency nevertheless.  Returns also what is left without
    a fit.
    """
    found, left = list(prepared), []
    for one in refused:
        begun = None if one.shot.rotor is None else _begun(one.shot, model)
        if begun is None:
            left.append(one)
        else:
            found.append(begun)
    return _on_one_side(found, model) if found else found, left


def _begun(shot: DiagnosisShot, model: RingDownModel) -> PreparedShot | None:
    record = shot.record
    last = min(record.end, record.valid_from + round(_LIMITS.beginning_s * shot.rate_hz))
    part = replace(record, valid_to=last)
    held = fixed_values(model, None, dipole=observes_dipole(part, model))
    try:
        beginning = prepare_record(part, "d30", shot.noise, held)
    except RefusedError:
        return None
    found = find_minimum_coarsely(beginning, model)
    if found is None:
        return None
    state = by_convention(found[1].state, model)
    frequency_hz = state.dynamics.w / (2.0 * math.pi)
    grids = grids_for(record, record.end, frequency_hz)
    return PreparedShot(shot, state, grids, whitening_for(shot, grids, frequency_hz))


def _on_one_side(prepared: Sequence[PreparedShot], model: RingDownModel) -> list[PreparedShot]:
    """Every shot as the twin (phi -> -phi) nearest to the first shot: common strengths and means need one side.

    Where e_v is perpendicular to x, noise decides which of the two a fit finds.
    """
    return [replace(s, state=nearer_mirror_image(s.state, prepared[0].state, model)) for s in prepared]


def nearer_mirror_image(state: FitState, reference: FitState, model: RingDownModel) -> FitState:
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
        state = anchored_before(by_convention(_minimum(shot, model), model), model)
        last = _end(shot, model, state)
    except (RefusedError, LostTrajectoryError) as error:
        return UnfittedShot(shot, str(error))
    frequency_hz = state.dynamics.w / (2.0 * math.pi)
    grids = grids_for(shot.record, last, frequency_hz)
    return PreparedShot(shot, state, grids, whitening_for(shot, grids, frequency_hz))


def anchored_before(state: FitState, model: RingDownModel) -> FitState:
    """The state with its anchor before the first sample, where it lies long after it.

    A motion arrives at an anchor without another turning point in between. Of a swing that is released at the first
    sample an anchor half a cycle later is at the very limit of that, and no effect could move it further.
    """
    d = state.dynamics
    if d.theta > -0.5 * math.pi:
        return state
    (phi, v), _ = state_at_zero(model, d)
    try:
        return replace(state, dynamics=dynamics_through(model, w=d.w, values=d.values, phi=float(phi), v=float(v)))
    except (ValueError, LostTrajectoryError):
        return state


def _minimum(shot: DiagnosisShot, model: RingDownModel) -> FitState:
    """Of the whole window; where a model that lacks much finds none there, of an angle's first eighth, and of a dipole
    as if the noise were a part of the signal.

    Raises RefusedError, LostTrajectoryError.
    """
    record = shot.record
    held = fixed_values(model, None, dipole=observes_dipole(record, model))
    try:
        return find_minimum(prepare_record(record, "d30", shot.noise, held), model)[1].state
    except RefusedError as error:
        if record.quantity == "angle":
            part = replace(record, valid_to=record.valid_from + (record.end - record.valid_from) // _LIMITS.first_part)
            return find_minimum(prepare_record(part, "d30", shot.noise, held), model)[1].state
        # Any other refusal is for what the signal shows, and not for the model that lacks something.
        coarse = None
        if error.code is Refusal.NO_CONVERGENCE:
            coarse = find_minimum_coarsely(prepare_record(record, "d30", shot.noise, held), model)
        if coarse is None:
            raise
        return coarse[1].state


def _end(shot: DiagnosisShot, model: RingDownModel, state: FitState) -> int:
    """Sample at which the motion has become small."""
    record = shot.record
    if record.quantity == "angle":
        return _end_of_angle(record, state)
    times, sizes = turning_points(model, state.dynamics, record.end * record.dt_s)
    small = np.flatnonzero(sizes < _LIMITS.kept_amplitude * abs(state.dynamics.amplitude))
    until_s = float(times[small[0]]) if small.size else float(times[-1])
    return min(record.end, max(record.valid_from, math.ceil(until_s * shot.rate_hz)))


def _end_of_angle(record: RingDownRecord, state: FitState) -> int:
    """The same as the samples themselves show it: friction that the model lacks may have stopped the swing long ago."""
    first = record.valid_from
    samples = record.samples[0, first : record.end]
    cycles = find_half_cycles(samples, first=first, dt_s=record.dt_s, frequency_hz=state.dynamics.w / (2.0 * math.pi))
    if cycles is None:
        return record.end
    sizes = np.abs(cycles.turning_rad)
    small = np.flatnonzero(sizes < _LIMITS.kept_amplitude * sizes[0])
    if small.size:
        return min(record.end, math.ceil(float(cycles.turning_s[small[0]]) / record.dt_s))
    # After the last significant swing the rotor rests, or the record ends.
    last_s = float(cycles.passages_s[-1]) + 0.5 * float(cycles.passages_s[-1] - cycles.passages_s[-2])
    return min(record.end, math.ceil(last_s / record.dt_s))
