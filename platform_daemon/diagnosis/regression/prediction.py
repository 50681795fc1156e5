"""The whole record that a hypothesis predicts, at every sample: for scores, clean records and pictures."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from platform_daemon.diagnosis.shots.linearisation import Linearisation, basis_with_slopes
from platform_daemon.diagnosis.shots.shot import PreparedShot, SampleGrid, whitening_for
from platform_daemon.diagnosis.shots.torque_course import course_of
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.numerics.arrays import Array

from .hypothesis import Hypothesis
from .joint_fit import JointFit
from .linearised_shot import LinearisedShot


def window_of(prepared: PreparedShot) -> tuple[int, int]:
    """First and last (exclusive) sample of the shot's window."""
    first, last = prepared.grids[0], prepared.grids[-1]
    return first.first * first.factor, last.last * last.factor


def predicted(hypothesis: Hypothesis, linear: LinearisedShot, state: FitState, strengths: Array, own: Array) -> Array:
    """Channels (channels, n) over the shot's window, offsets and all effects included.

    linear: the linearised shot. state: of the declared model. own: sizes of the additive effects that the shot has for
    itself.
    """
    linearisation = _whole(linear.linearisation.prepared, hypothesis, state, strengths)
    return np.asarray(
        linearisation.signal + _non_torque(linearisation, hypothesis, strengths, own) + state.offsets[:, None]
    )


def non_torque_signal(
    prepared: PreparedShot, hypothesis: Hypothesis, state: FitState, strengths: Array, own: Array
) -> Array:
    """Sum of all effects but torques over the shot's window, (channels, n); see `predicted`."""
    return _non_torque(_whole(prepared, hypothesis, state, strengths), hypothesis, strengths, own)


def _non_torque(whole: Linearisation, hypothesis: Hypothesis, strengths: Array, own: Array) -> Array:
    return np.asarray(hypothesis.changes(whole, strengths) + _additive(hypothesis, whole, strengths, own))


def unpredicted(at: JointFit, k: int) -> Array:
    """Data of shot k minus all that the joint fit holds, at every sample of its window, (channels, n)."""
    prepared, linear = at.prepared[k], at.linear[k]
    own = own_sizes(at.hypothesis, linear, at.strengths)
    first, last = window_of(prepared)
    model = predicted(at.hypothesis, linear, at.states[k], at.strengths, own)
    return np.asarray(prepared.shot.record.samples[:, first:last] - model)


def _whole(prepared: PreparedShot, hypothesis: Hypothesis, state: FitState, strengths: Array) -> Linearisation:
    """The model at every sample of the window, without residual and Jacobian."""
    full, model = hypothesis.extended(state, strengths), hypothesis.augmented
    course = course_of(state)
    if course is not None:
        full, model = course.extended(full), course.model(model, frozen=True)
    every = _every_sample(prepared)
    return Linearisation.of_basis(every, full, *basis_with_slopes(every, model, full))


def _every_sample(prepared: PreparedShot) -> PreparedShot:
    """The shot on a grid of all samples of its window."""
    grid = (SampleGrid(1, *window_of(prepared)),)
    fundamental_hz = prepared.state.dynamics.w / (2.0 * math.pi)
    return PreparedShot(prepared.shot, prepared.state, grid, whitening_for(prepared.shot, grid, fundamental_hz))


def _additive(hypothesis: Hypothesis, whole: Linearisation, strengths: Array, own: Array) -> Array:
    """Sum of the additive effects over the window, (channels, n); whole: the model at all its samples."""
    out = np.zeros_like(whole.odd)
    linearisation, place = replace(whole, residual=out), 0
    for c in hypothesis.effects:
        if not c.additive or c.columns is None:
            continue
        columns = c.columns(linearisation)
        if c.shared:
            where = next(s for o, s in zip(hypothesis.common, hypothesis.slices, strict=True) if o is c)
            sizes = strengths[where]
        else:
            sizes = own[place : place + columns.shape[0]]
            place += columns.shape[0]
        out = out + np.tensordot(sizes, columns, 1)
    return out


def own_sizes(
    hypothesis: Hypothesis, linear: LinearisedShot, strengths: Array, keep: np.ndarray | None = None
) -> Array:
    """Amplitudes of the shot's own additive effects that fit its residual, optionally of the rows `keep` only."""
    columns = hypothesis.own_columns(linear.linearisation).T
    if columns.shape[1] == 0:
        return np.empty(0)
    residual = linear.linearisation.whitened - hypothesis.additive_part(
        strengths, hypothesis.shared_columns(linear.linearisation)
    )
    if keep is not None:
        columns, residual = columns[keep], residual[keep]
    return np.asarray(np.linalg.lstsq(columns, residual, rcond=None)[0])
