"""The local linear picture of one shot: what is left of the data at a state, and how it moves with every parameter."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from platform_daemon.estimation.arrays import Array
from platform_daemon.estimation.gauss_newton import FitState
from platform_daemon.estimation.models import RingDownModel
from platform_daemon.estimation.trajectory import Trajectory

from .shots import Grid, Shot


@dataclass(frozen=True)
class Look:
    """A shot at a state of a model, on its grids, all pieces side by side.

    Attributes:
        time_s: (m,).
        signal, slope: (channels, m) the model's channels and their time derivatives, without offsets.
        residual: (channels, m) data minus model.
        jacobian: (p, channels, m) d model / d parameter, in the order of FitState.moved.
        odd, even: (channels, m) parts of the signal from f1 and f2, near odd and even multiples of the fundamental.
        phi, v: (m,) the motion: angle in rad, angular velocity over w.
        scale: (channels, m) 1 / standard deviation of the noise.
    """

    shot: Shot
    state: FitState
    time_s: Array
    signal: Array
    slope: Array
    odd: Array
    even: Array
    residual: Array
    jacobian: Array
    scale: Array

    @cached_property
    def whitened(self) -> Array:
        """Residual in units of its noise, flat (channels m,)."""
        return np.asarray((self.residual * self.scale).ravel())

    @cached_property
    def base(self) -> Array:
        """Jacobian in units of the noise, (p, channels m)."""
        return np.asarray((self.jacobian * self.scale).reshape(self.jacobian.shape[0], -1))

    def white(self, columns: Array) -> Array:
        """Columns (q, channels, m) in units of the noise, (q, channels m)."""
        return np.asarray((columns * self.scale).reshape(columns.shape[0], -1))


def look(shot: Shot, samples: Array, model: RingDownModel, state: FitState, grids: tuple[Grid, ...]) -> Look:
    """Evaluate a state.

    samples: (channels, n), the shot's, or these freed from what the receiver did to them.

    Raises:
        LostTrajectoryError: the state does not oscillate.
    """
    d, obs, rate = state.dynamics, state.observation, shot.record.sampling_rate_hz
    ends = max(g.last * g.factor for g in grids)
    trajectory = Trajectory(model, d, ends / rate)
    bases = [trajectory.basis(g.first, g.last, g.factor / rate, obs.observable) for g in grids]
    basis = np.concatenate(bases, axis=1)
    data = np.concatenate([g.of(samples) for g in grids], axis=1)
    gains = obs.gains(d.w)
    odd, even = gains[:, :1] * basis[0], gains[:, 1:] * basis[1]
    slope = d.w * (gains @ basis[2:4])
    signal = odd + even
    scale = np.concatenate([np.full(g.count, np.sqrt(g.factor)) for g in grids]) / shot.noise_sd[:, None]
    return Look(
        shot=shot,
        state=state,
        time_s=np.concatenate([np.arange(g.first, g.last) * (g.factor / rate) for g in grids]),
        signal=signal,
        slope=slope,
        odd=odd,
        even=even,
        residual=data - signal - state.offsets[:, None],
        jacobian=_jacobian(model, state, basis),
        scale=scale,
    )


def _jacobian(model: RingDownModel, state: FitState, basis: Array) -> Array:
    """(p, channels, m) from the kernel's basis (b, m)."""
    d, obs = state.dynamics, state.observation
    gains, by_w, by_own = obs.gains(d.w), obs.gains_by_w(d.w), obs.gains_by_own(d.w)
    chain = d.chain(model)
    dynamic, channels, m = chain.shape[0], gains.shape[0], basis.shape[1]
    out = np.zeros((state.size, channels, m))
    moved1 = chain.T @ basis[2 : 2 + 2 * dynamic : 2]
    moved2 = chain.T @ basis[3 : 3 + 2 * dynamic : 2]
    out[:dynamic] = moved1[:, None] * gains[:, :1] + moved2[:, None] * gains[:, 1:]
    out[1] += by_w @ basis[:2]
    out[dynamic : dynamic + obs.size] = by_own @ basis[:2]
    for channel in range(channels):
        out[dynamic + obs.size + channel, channel] = 1.0
    return out
