"""The whole record that a hypothesis predicts, at every sample: for scores, clean records and pictures."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from platform_daemon.estimation import Array, FitState

from ..shots.linearisation import Linearisation, basis_at
from ..shots.shot import PreparedShot, SampleGrid, whitening_for
from .hypothesis import Hypothesis
from .joint_fit import JointFit
from .linearised_shot import LinearisedShot


def window_of(started: PreparedShot) -> tuple[int, int]:
    """First and last (exclusive) sample of the shot's window."""
    first, last = started.grids[0], started.grids[-1]
    return first.first * first.factor, last.last * last.factor


def predicted(hypothesis: Hypothesis, linear: LinearisedShot, state: FitState, strengths: Array, own: Array) -> Array:
    """Channels (channels, n) over the shot's window, offsets and all effects included.

    linear: a look at the shot. state: of the declared model. own: sizes of the additive effects that the shot has for
    itself.
    """
    seen = _whole(linear.seen.started, hypothesis, state, strengths)
    return np.asarray(seen.signal + _beside(seen, hypothesis, strengths, own) + state.offsets[:, None])


def beside_motion(
    started: PreparedShot, hypothesis: Hypothesis, state: FitState, strengths: Array, own: Array
) -> Array:
    """What all effects but torques put into the channels (channels, n) of the shot's window; see `predicted`."""
    return _beside(_whole(started, hypothesis, state, strengths), hypothesis, strengths, own)


def _beside(whole: Linearisation, hypothesis: Hypothesis, strengths: Array, own: Array) -> Array:
    return np.asarray(hypothesis.changes(whole, strengths) + _additive(hypothesis, whole, strengths, own))


def unpredicted(at: JointFit, k: int) -> Array:
    """Data of shot k minus all that the joint fit holds, at every sample of its window, (channels, n)."""
    started, linear = at.started[k], at.linear[k]
    own = own_sizes(at.hypothesis, linear, at.strengths)
    first, last = window_of(started)
    model = predicted(at.hypothesis, linear, at.states[k], at.strengths, own)
    return np.asarray(started.shot.record.samples[:, first:last] - model)


def _whole(started: PreparedShot, hypothesis: Hypothesis, state: FitState, strengths: Array) -> Linearisation:
    """A look at every sample of the window, without residual and derivatives."""
    full, model = hypothesis.extended(state, strengths), hypothesis.augmented
    every = _every_sample(started)
    basis = basis_at(every, model, full)
    return Linearisation.of_basis(every, full, basis)


def _every_sample(started: PreparedShot) -> PreparedShot:
    """The shot on a grid of all samples of its window."""
    grid = (SampleGrid(1, *window_of(started)),)
    fundamental_hz = started.state.dynamics.w / (2.0 * math.pi)
    return PreparedShot(started.shot, started.state, grid, whitening_for(started.shot, grid, fundamental_hz))


def _additive(hypothesis: Hypothesis, whole: Linearisation, strengths: Array, own: Array) -> Array:
    """What additive effects put into the window, (channels, n); whole: a look at all its samples."""
    out = np.zeros_like(whole.odd)
    seen, place = replace(whole, residual=out), 0
    for c in hypothesis.effects:
        if not c.additive or c.columns is None:
            continue
        columns = c.columns(seen)
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
    """Sizes of the additive effects of the shot's own that fit what is left of a look, of its rows `keep` only."""
    columns = hypothesis.own_columns(linear.seen).T
    if columns.shape[1] == 0:
        return np.empty(0)
    residual = linear.seen.whitened - hypothesis.additive_part(strengths, hypothesis.shared_columns(linear.seen))
    if keep is not None:
        columns, residual = columns[keep], residual[keep]
    return np.asarray(np.linalg.lstsq(columns, residual, rcond=None)[0])
