"""The motion itself at a shot's instants, and how it answers to a small extra torque of any form.

The answer solves the linearised equation of motion in dimensionless time s = w t,

    d'' = tau_phi d + tau_v d' + F(phi, v),

by Runge-Kutta steps between the instants; where friction changes its sign, d' jumps by the ratio of the accelerations
after and before. This is accurate to a per cent: enough for a torque that nobody has a name for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.diagnosis.shots.kicked_motion import motion_basis
from platform_daemon.diagnosis.shots.shot import PreparedShot, SampleGrid
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.numerics.jit import kernel
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.torques.dispatch import acceleration
from platform_daemon.estimation.physics.trajectory.basis_functions import DIPOLE, STATE

_LIMITS = THRESHOLDS.regression
Forces = Callable[[Array, Array], Array]


@dataclass(frozen=True)
class SampledMotion:
    """phi in rad and v = phi' / w at the instants, (m,) each; amplitude in rad and phase in rad of the swing there."""

    phi: Array
    v: Array

    @property
    def amplitude(self) -> Array:
        """Deflection at which the energy would be potential only, (m,)."""
        return np.arccos(np.clip(np.cos(self.phi) - 0.5 * self.v**2, -1.0, 1.0))

    @property
    def phase(self) -> Array:
        """0 at a turning point on the positive side, growing, (m,); the harmonics of the signal follow it."""
        amplitude = np.maximum(self.amplitude, _LIMITS.least_amplitude_rad)
        return np.arctan2(-self.v / (2.0 * np.sin(0.5 * amplitude)), self.phi / amplitude)


def sample_motion(prepared: PreparedShot, model: RingDownModel, state: FitState) -> SampledMotion:
    """The motion at the instants.  Raises LostTrajectoryError."""
    pieces = [_piece(prepared, model, state, g, 1) for g in prepared.grids]
    return SampledMotion(np.concatenate([p.phi for p in pieces]), np.concatenate([p.v for p in pieces]))


@kernel
def integrate_responses(phi, v, force, h, split, codes, widths, c, at, dipole, out):  # type: ignore[no-untyped-def]
    """March the answers to extra torques along the motion, from `at` (2, k) = (d, d') on, which moves along.

    phi, v (split (m - 1) + 1,) with an even number `split` of half steps of h between the instants; force (k, ...) at
    the same places. out (2, k, m): change of f1, f2 (basis_functions.py) at the instants.
    """
    grad = np.zeros(c.size + 1)
    k = force.shape[0]
    count = out.shape[2]
    slopes = np.empty((3, 2))
    for place in range(count):
        i = place * split
        sine = np.sin(phi[i])
        cosine = np.cos(phi[i])
        for q in range(k):
            if dipole:
                out[0, q, place] = -v[i] * sine * at[0, q] + cosine * at[1, q]
                out[1, q, place] = -v[i] * cosine * at[0, q] - sine * at[1, q]
            else:
                out[0, q, place] = at[0, q]
                out[1, q, place] = at[1, q]
        if place == count - 1:
            break
        for step in range(split // 2):
            a = i + 2 * step
            side = 1.0 if v[a + 1] >= 0.0 else -1.0
            for n in range(3):
                _, slopes[n, 0], slopes[n, 1] = acceleration(phi[a + n], v[a + n], side, codes, widths, c, grad)
            jump = 0.0
            left = 0.0
            if v[a] * v[a + 2] < 0.0:
                before, _, _ = acceleration(phi[a + 1], 0.0, 1.0 if v[a] > 0.0 else -1.0, codes, widths, c, grad)
                after, _, _ = acceleration(phi[a + 1], 0.0, 1.0 if v[a + 2] > 0.0 else -1.0, codes, widths, c, grad)
                jump = after / before - 1.0
                # The jump comes inside the step; the rest of the step moves on with the new velocity.
                left = 2.0 * h * v[a + 2] / (v[a + 2] - v[a])
            for q in range(k):
                x = at[0, q]
                y = at[1, q]
                k1 = slopes[0, 0] * x + slopes[0, 1] * y + force[q, a]
                x2 = x + h * y
                y2 = y + h * k1
                k2 = slopes[1, 0] * x2 + slopes[1, 1] * y2 + force[q, a + 1]
                x3 = x + h * y2
                y3 = y + h * k2
                k3 = slopes[1, 0] * x3 + slopes[1, 1] * y3 + force[q, a + 1]
                x4 = x + 2.0 * h * y3
                y4 = y + 2.0 * h * k3
                k4 = slopes[2, 0] * x4 + slopes[2, 1] * y4 + force[q, a + 2]
                moved = y + h / 3.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
                kick = jump * (moved + (y - moved) * left / (2.0 * h))
                at[0, q] = x + h / 3.0 * (y + 2.0 * y2 + 2.0 * y3 + y4) + kick * left
                at[1, q] = moved + kick
    return 0


def torque_responses(prepared: PreparedShot, model: RingDownModel, state: FitState, forces: Forces) -> Array:
    """Change of the record's channels per unit of extra torques, (k, channels, m).

    forces: (phi (n,), v (n,)) -> torques (k, n) in units of I w^2.  The linearised motion is integrated grid by grid;
    the state that one grid ends with is the start of the next.

    Raises:
        LostTrajectoryError: the state does not oscillate.
    """
    d, obs, rate = state.dynamics, state.observation, prepared.shot.rate_hz
    coefficients = d.dimensionless(model)
    at: Array | None = None  # (2, k): deviation of angle and velocity at the start of the grid, zero at the record's
    gains = obs.gains(d.w)  # (channels, 2): how the two components of `out` enter the channels
    pieces = []
    for g in prepared.grids:
        ds = d.w * g.factor / rate
        split = 2 * max(1, int(np.ceil(ds / _LIMITS.response_step_rad)))
        # To the first instant of the next grid, one step after the last of this one.
        moving = _piece(prepared, model, state, replace(g, last=g.last + 1), split)
        force = forces(moving.phi, moving.v)
        at = np.zeros((2, force.shape[0])) if at is None else at
        out = np.empty((2, force.shape[0], g.count + 1))
        args = model.codes, model.widths, coefficients, at, obs.observable == DIPOLE, out
        integrate_responses(moving.phi, moving.v, force, ds / split, split, *args)
        pieces.append(gains[:, :1] * out[0, :, None, :-1] + gains[:, 1:] * out[1, :, None, :-1])
    return np.concatenate(pieces, axis=2)


def _piece(
    prepared: PreparedShot, model: RingDownModel, state: FitState, grid: SampleGrid, split: int
) -> SampledMotion:
    """The motion at the instants of a grid and at split - 1 places between any two of them."""
    last = split * (grid.last - 1) + 1
    step = grid.factor / prepared.shot.rate_hz / split
    basis, _ = motion_basis(model, state, split * grid.first, last, step, STATE)
    return SampledMotion(basis[0], basis[1])
