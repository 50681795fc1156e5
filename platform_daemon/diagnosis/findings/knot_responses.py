"""The response of one shot to a parameter that changes along it: a compressed column for every knot of its trace.

See `regression.start_changes`: y moves by a(t) d y / d theta + b(t) d y / d A.

a and b move slowly, the derivatives by the start quickly: their products are summed over blocks of about a period
first, and columns are only ever written as slow factors of a few carriers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import solve_triangular

from platform_daemon.diagnosis.regression.linearised_shot import LinearisedShot
from platform_daemon.diagnosis.regression.start_changes import AMPLITUDE, THETA, W, start_changes
from platform_daemon.diagnosis.shots.kicked_motion import motion_basis
from platform_daemon.diagnosis.shots.shot import PreparedShot
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.least_squares.observation_model import DipoleObservation
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.basis_functions import STATE

_LIMITS = THRESHOLDS.findings
F_NAT, MOMENT, ZERO = "f_nat_hz", "m_r_am2", "zero_offset_rad"


@dataclass(frozen=True)
class Moving:
    """A parameter that may move: public name, its place in the state, and public over internal unit."""

    name: str
    place: int
    unit: float = 1.0


def moving_parameters_of(model: RingDownModel, state: FitState, quantity: str) -> list[Moving]:
    """Natural frequency, free coefficients of the torques, the moment of a dipole, the zero of an angle."""
    found = [Moving(F_NAT, W, 0.5 / math.pi)]
    for k, c in enumerate(model.coefficients, 3):
        if not c.hidden and model.parameters[c.name].fixed is None:
            found.append(Moving(c.name, k))
    if isinstance(state.observation, DipoleObservation):
        found.append(Moving(MOMENT, 3 + len(model.coefficients)))
    if quantity == "angle":
        found.append(Moving(ZERO, state.size - 1))
    return found


@dataclass(frozen=True, kw_only=True)
class SlowMotion:
    """A shot in blocks of about a period.

    Attributes:
        time_s: (n + 1,) of their edges.
        amplitude, peak_speed: (n + 1,) of the swing, rad and rad/s.
        turned, grown: (parameters of the state's motion, n) by how much each changes theta and A of the start within
            each block.
    """

    time_s: Array
    amplitude: Array
    peak_speed: Array
    turned: Array
    grown: Array


def slow_motion(prepared: PreparedShot, model: RingDownModel, state: FitState) -> SlowMotion:
    """Of a shot at a state.  Raises LostTrajectoryError."""
    d, times = state.dynamics, prepared.time_s
    periods = (times[-1] - times[0]) * d.w / (2.0 * math.pi)
    blocks = int(min(max(periods, _LIMITS.fewest_blocks), _LIMITS.most_blocks))
    dt_s = float(times[-1] - times[0]) / blocks
    first, last = math.floor(times[0] / dt_s), math.ceil(times[-1] / dt_s) + 1
    basis, _ = motion_basis(model, state, first, last, dt_s, STATE)
    changes = start_changes(model, state, basis)
    amplitude = np.arccos(np.clip(np.cos(basis[0]) - 0.5 * basis[1] ** 2, -1.0, 1.0))
    times_s, speed = np.arange(first, last) * dt_s, 2.0 * d.w * np.sin(0.5 * amplitude)
    return SlowMotion(time_s=times_s, amplitude=amplitude, peak_speed=speed, turned=changes.turned, grown=changes.grown)


@dataclass(frozen=True, kw_only=True)
class KnotResponses:
    """Information of one shot on the traces, ordered by parameter, then by knot.

    Attributes:
        information, gradient: (k, k), (k,) beside the shot's own parameters.
        follows: (parameters, k) response of the shot's own value of each parameter to a trace, internal unit.
        variance: (parameters,) of that value.
        motion: the shot in blocks.
        carriers: quick rows (carriers, rows); slow: (k, carriers, blocks) by what they are multiplied.
    """

    information: Array
    gradient: Array
    follows: Array
    variance: Array
    motion: SlowMotion
    carriers: Array
    slow: Array

    def after_trace(self, linear: LinearisedShot, time_s: Array, trace: Array) -> LinearisedShot:
        """The shot with the residual after a trace (k,); time_s: of its instants."""
        factors = np.tensordot(trace, self.slow, 1)
        edges = self.motion.time_s
        middle, channels = 0.5 * (edges[1:] + edges[:-1]), linear.residual.size // time_s.size
        answer = np.zeros(linear.residual.size)
        for carrier, factor in zip(self.carriers, factors, strict=True):
            answer += carrier * np.tile(np.interp(time_s, middle, factor), channels)
        return replace(linear, residual=linear.without_own(linear.residual - answer))


def splines(time_s: Array, knots: Array) -> Array:
    """Windows (knots, n) that add up to one: cubic splines that are 1 at one knot and 0 at all others."""
    return np.asarray(CubicSpline(knots, np.eye(knots.size))(time_s).T)


def knot_responses(
    prepared: PreparedShot, linear: LinearisedShot, model: RingDownModel, moving: list[Moving], knots: Array
) -> KnotResponses:
    """Of one shot at its state of the declared model; knots: times, s.  Raises LostTrajectoryError."""
    motion = slow_motion(prepared, model, linear.linearisation.state)
    windows = splines(0.5 * (motion.time_s[1:] + motion.time_s[:-1]), knots)
    base, free = linear.base().T, linear.free
    additive = [m.place for m in moving if m.place >= 3 + len(model.coefficients)]
    carriers = base[[THETA, AMPLITUDE, *additive]]
    factors = np.zeros((len(moving), knots.size, carriers.shape[0], windows.shape[1]))
    for k, m in enumerate(moving):
        if m.place in additive:
            factors[k, :, 2 + additive.index(m.place)] = windows
            continue
        for carrier, rate in enumerate((motion.turned[m.place], motion.grown[m.place])):
            done = windows * rate
            factors[k, :, carrier] = np.cumsum(done, axis=1) - 0.5 * done
    slow = factors.reshape(-1, carriers.shape[0], windows.shape[1])
    own = np.concatenate([linear.own, linear.q], axis=1)
    sums = _block_sums(prepared, carriers, np.concatenate([carriers, own.T, linear.residual[None]]), motion.time_s)
    gram, inside, gradient = np.split(sums, [carriers.shape[0], -1], axis=1)
    weighted = np.einsum("kcn,cdn->kdn", slow, gram)
    whole = weighted.reshape(slow.shape[0], -1) @ slow.reshape(slow.shape[0], -1).T
    within = np.einsum("kcn,cpn->kp", slow, inside)
    of_residual = np.einsum("kcn,cn->k", slow, gradient[:, 0])
    answer = np.zeros((free.size, slow.shape[0]))
    answer[free] = -solve_triangular(linear.triangle, within[:, linear.own.shape[1] :].T) * linear.scale[:, None]
    places = [m.place for m in moving]
    return KnotResponses(
        information=whole - within @ within.T,
        gradient=of_residual - within @ (own.T @ linear.residual),
        follows=answer[places],
        variance=np.diag(linear.own_covariance())[places],
        motion=motion,
        carriers=carriers,
        slow=slow,
    )


def _block_sums(prepared: PreparedShot, carriers: Array, others: Array, edges_s: Array) -> Array:
    """Sums of products of whitened rows over the instants of every block, (carriers, others, blocks)."""
    times, blocks = prepared.time_s, edges_s.size - 1
    place = np.clip(np.searchsorted(edges_s, times, side="right") - 1, 0, blocks - 1)
    begins = np.flatnonzero(np.diff(place, prepend=-1))
    shape = (-1, times.size)
    wide = others.reshape(others.shape[0], *(-1, times.size))
    out = np.zeros((carriers.shape[0], others.shape[0], blocks))
    for k, carrier in enumerate(carriers):
        products = np.einsum("ocm,cm->om", wide, carrier.reshape(shape))
        out[k][:, place[begins]] = np.add.reduceat(products, begins, axis=1)
    return out
