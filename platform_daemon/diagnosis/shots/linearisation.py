"""The local linear picture of one shot: what is left of the data at a state, and how it moves with every parameter."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from platform_daemon.estimation import (
    REACH,
    STATE,
    Array,
    FitState,
    LostTrajectoryError,
    RingDownModel,
    Trajectory,
    Workspace,
    coefficient_jacobian,
    derivative,
)

from .shot import PreparedShot

_STRAY = 3.0  # times the frequency of the shot's own fit
_KEPT = 2  # states of a shot: some megabytes each
_LARGEST = 1e60  # of sensitivities; beyond, nothing of the motion is left


@dataclass(frozen=True)
class Linearisation:
    """A shot at a state of a model, on its grids, all pieces side by side.

    Attributes:
        started: the shot with its grids.
        state: the state looked from.
        odd, even: (channels, m) parts of the model's channels from f1 and f2, near odd and even multiples of the
            fundamental, without offsets.
        slopes: (2, channels, m) time derivatives of these two parts.
        residual: (channels, m) data minus model.
        jacobian: (p, channels, m) d model / d parameter, in the order of FitState.moved; even_jacobian: its part from
            f2.
        free_motion: (2, 2, m) of an angle: two solutions of the linearised equation of motion, angle and velocity /w;
            (2, 2, 0) of what else is recorded.
    """

    started: PreparedShot
    state: FitState
    odd: Array
    even: Array
    slopes: Array
    residual: Array
    jacobian: Array
    even_jacobian: Array
    free_motion: Array

    @classmethod
    def of_basis(cls, started: PreparedShot, state: FitState, basis: Array) -> Linearisation:
        """The model's channels only, from the kernel's basis (b, m): no residual, no Jacobian."""
        d, gains = state.dynamics, state.observation.gains(state.dynamics.w)
        odd, even = gains[:, :1] * basis[0], gains[:, 1:] * basis[1]
        slopes = d.w * np.stack([gains[:, :1] * basis[2], gains[:, 1:] * basis[3]])
        nothing = np.zeros((0, *odd.shape))
        # Derivatives by phase and by amplitude.
        free = np.stack([basis[2:4], basis[6:8]]) if state.observation.observable == STATE else np.zeros((2, 2, 0))
        return cls(started, state, odd, even, slopes, nothing, nothing, nothing, free)

    def moved(self, parameter: int, step: float) -> Linearisation:
        """The model's channels after a small step of a parameter, to first order; not of an offset."""
        even = step * self.even_jacobian[parameter]
        odd = step * self.jacobian[parameter] - even
        slopes = np.stack([self._derived(part) for part in (odd, even)])
        return replace(self, odd=self.odd + odd, even=self.even + even, slopes=self.slopes + slopes)

    def without_jacobian(self) -> Linearisation:
        """The same for keeping: derivatives take ten times the room of everything else."""
        nothing = np.zeros((0, *self.odd.shape))
        kept = replace(self, jacobian=nothing, even_jacobian=nothing)
        kept.__dict__["whitened"] = self.whitened
        return kept

    @property
    def time_s(self) -> Array:
        """(m,)."""
        return self.started.time_s

    @cached_property
    def signal(self) -> Array:
        """(channels, m) the model's channels, without offsets."""
        return np.asarray(self.odd + self.even)

    @cached_property
    def slope(self) -> Array:
        """(channels, m) its time derivative."""
        return np.asarray(self.slopes.sum(axis=0))

    @cached_property
    def _derivatives(self) -> list[Array]:
        return [np.asarray(self.started.shot.to_volts @ self.slope)]

    def derivative_v(self, order: int) -> Array:
        """(channels, m) time derivative of this order at the digitiser, found once."""
        found = self._derivatives
        while len(found) < order:
            found.append(self._derived(found[-1]))
        return found[order - 1]

    def _derived(self, samples: Array) -> Array:
        """Time derivative (channels, m), piece by piece."""
        rate, grids = self.started.shot.rate_hz, self.started.grids
        parts = []
        for k, (g, where) in enumerate(zip(grids, self.started.white.slices, strict=True)):
            before, after = self._beside(samples, k)
            wide = derivative(np.concatenate([before, samples[:, where], after], axis=1), rate / g.factor)
            parts.append(wide[:, before.shape[1] : wide.shape[1] - after.shape[1]])
        return np.concatenate(parts, axis=1)

    def _beside(self, samples: Array, k: int) -> tuple[Array, Array]:
        """Samples before and after a decimated piece at its own step, from its neighbours that have every sample.

        From a decimated piece alone, derivatives at its ends would be poor.
        """
        grids, slices = self.started.grids, self.started.white.slices
        factor, nothing = grids[k].factor, samples[:, :0]
        if factor == 1 or len(grids) == 1:
            return nothing, nothing
        before, after = samples[:, slices[k - 1]], samples[:, slices[k + 1]]
        return before[:, ::-1][:, factor - 1 :: factor][:, :REACH][:, ::-1], after[:, ::factor][:, :REACH]

    @cached_property
    def whitened(self) -> Array:
        """Residual in units of its noise, flat (channels m,)."""
        return self.started.white(self.residual)

    @cached_property
    def base(self) -> Array:
        """Jacobian in units of the noise, (p, channels m)."""
        return self.started.white(self.jacobian)

    @cached_property
    def volts(self) -> Array:
        """The model's channels at the digitiser, (channels, m)."""
        return np.asarray(self.started.shot.to_volts @ self.signal)


def linearise_signal(started: PreparedShot, model: RingDownModel, state: FitState) -> Linearisation:
    """Evaluate a state.

    Raises:
        LostTrajectoryError: the state does not oscillate, or has left what the shot can be.
    """
    _check(started, state)
    basis = basis_at(started, model, state)
    if not np.abs(basis).max() < _LARGEST:
        raise LostTrajectoryError("the motion answers without bounds to its parameters")
    seen = Linearisation.of_basis(started, state, basis)
    residual = started.data - seen.signal - state.offsets[:, None]
    by_parameter = coefficient_jacobian(model, state)
    even = np.tensordot(by_parameter[..., 1::2], basis[1::2], 1)
    return replace(seen, residual=residual, jacobian=np.tensordot(by_parameter, basis, 1), even_jacobian=even)


def _check(started: PreparedShot, state: FitState) -> None:
    """A trial step may lead anywhere; tables and traces of such a motion would be as large."""
    here, begun = state.dynamics, started.state.dynamics
    if not (_STRAY > here.w / begun.w > 1.0 / _STRAY and abs(here.amplitude) < math.pi):
        raise LostTrajectoryError("the motion is no longer that of the shot")


def basis_at(started: PreparedShot, model: RingDownModel, state: FitState, observable: int | None = None) -> Array:
    """The kernel's basis at the instants, (b, m), read-only: many a state is asked for again.

    observable: None: what was recorded.
    """
    observable = state.observation.observable if observable is None else observable
    places = tuple((g.first, g.last, g.factor) for g in started.grids)
    key = (model.terms, state.dynamics, observable, places)
    found = started.bases.get(key)
    if found is None:
        found = _basis(started, model, state, observable)
        found.flags.writeable = False
        while len(started.bases) >= _KEPT:
            started.bases.pop(next(iter(started.bases)), None)
        started.bases[key] = found
    return found


def _basis(started: PreparedShot, model: RingDownModel, state: FitState, observable: int) -> Array:
    d, rate = state.dynamics, started.shot.rate_hz
    # Torques that depend on time are integrated once; the others have tables.
    places = [(g.first, g.last, g.factor / rate) for g in started.grids]
    if model.time_dependent:
        trajectory = Trajectory(model, d, max(last * dt_s for _, last, dt_s in places))
        return np.concatenate([trajectory.basis(*place, observable) for place in places], axis=1)
    workspace = Workspace(model)
    return np.concatenate([workspace.basis(d, *place, observable) for place in places], axis=1)
