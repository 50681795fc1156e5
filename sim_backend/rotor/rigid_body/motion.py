"""Integrates the motion of the rigid rotor in pieces, which the receive side evaluates."""

from __future__ import annotations

from math import atan2, sqrt

import numpy as np
from numpy.typing import NDArray

from drivers.errors import DeviceError
from sim_backend.rotor.collocation import C, to_powers
from sim_backend.rotor.kernel import kernel
from sim_backend.rotor.pieces import NODES, PIECE_SLOTS, Motion

from .acceleration import JEWEL, N_DOT, OMEGA, STATES, Q, project, rates, turned
from .integrator import LAST, ROWS, attempt, orientation_at, prepare_dense

# A piece is one of `rotor.motion` followed by the powers of g_w; dm/dt = m_r (g_u e_u + g_v e_v + g_w e_w).
G_W = PIECE_SLOTS
RIGID_PIECE_SLOTS = PIECE_SLOTS + NODES

FINISHED, BUFFER_FULL, STEP_TOO_SMALL = 0, 1, 2
STEP_ANGLE_RAD = 0.2
TOLERANCE, SIDE_TOLERANCE = 1e-11, 1e-9  # of 1 for directions, of omega_nat for speeds, per step
SHORTEST_S = 1e-13
FIRST_STEP_S = 1e-6
STILL = 3.0  # times the slowest spin: a slower contact counts as creeping
MOST_STEPS = 400  # limit of the steps, as a multiple of those of a free swing
NO_FIELD = np.zeros((0, 6))


@kernel
def azimuth(y, p):  # type: ignore[no-untyped-def]
    """Angle of the moment about w, rad, its rate, rad/s, and the moment's unit vector's rate along u, v, w, rad/s."""
    size = sqrt(p[14] * p[14] + p[15] * p[15] + p[16] * p[16])
    m0, m1, m2 = turned(y, p[14] / size, p[15] / size, p[16] / size)
    w0, w1, w2 = y[10], y[11], y[12]
    g0, g1, g2 = w1 * m2 - w2 * m1, w2 * m0 - w0 * m2, w0 * m1 - w1 * m0
    return atan2(m1, m0), (m0 * g1 - m1 * g0) / (m0 * m0 + m1 * m1), g0, g1, g2


@kernel
def _store(row, start, h, y, p, dense, work, nodal, powers):  # type: ignore[no-untyped-def]
    """Fill a piece from the dense output of a step; nodal: (4, NODES): rate of the angle, g_u, g_v, g_w."""
    row[0] = start
    row[1] = h
    row[2], row[3], _, _, _ = azimuth(y, p)
    for i in range(NODES):
        orientation_at(C[i], y, dense, work)
        _, nodal[0, i], nodal[1, i], nodal[2, i], nodal[3, i] = azimuth(work, p)
    to_powers(nodal[0], powers)
    for k in range(NODES - 1):
        row[4 + k] = 2.0 / h * (k + 1) * powers[k + 1]
    row[3 + NODES] = 0.0
    for axis in range(3):
        to_powers(nodal[1 + axis], row[4 + (1 + axis) * NODES : 4 + (2 + axis) * NODES])


@kernel
def _is_still(y, rate, p, omega):  # type: ignore[no-untyped-def]
    """True if friction holds a jewel's rotor, which then only creeps."""
    if p[0] == 0.0 or p[22] == 0.0:
        return False
    slow = STILL * p[25]
    small = True
    for i in range(3):
        small = small and abs(y[3 + i]) < slow and abs(y[10 + i]) < slow
        small = small and abs(rate[3 + i]) < 0.01 * omega * slow and abs(rate[10 + i]) < 0.01 * omega * slow
    return small


@kernel
def march(start, end, origin, h, omega, y, p, terms, scale, pieces, count):  # type: ignore[no-untyped-def]
    """Advance the state y (STATES,) in place from `start` to `end` (s), writing pieces from row `count` on.

    origin: time zero of the field terms; h: first step, s; scale: (STATES,) tolerances.
    Returns (reason, time reached, next step, rows used, stuck at the end).
    """
    k, dense, nodal = np.zeros((LAST, STATES)), np.zeros((ROWS, STATES)), np.zeros((4, NODES))
    work, new, powers = np.zeros(STATES), np.zeros(STATES), np.zeros(NODES)
    h_max = STEP_ANGLE_RAD / omega
    t = start
    rates(t - origin, y, p, terms, k[0])
    while t < end:
        if count >= pieces.shape[0]:
            return BUFFER_FULL, t, h, count, False
        if terms.shape[0] == 0 and _is_still(y, k[0], p, omega):
            y[3:6] = 0.0
            y[10:13] = 0.0
            pieces[count, :] = 0.0
            pieces[count, 0] = t
            pieces[count, 1] = end - t
            pieces[count, 2] = azimuth(y, p)[0]
            return FINISHED, end, h, count + 1, True
        h = min(h, h_max)
        last = t + 1.01 * h >= end
        step = end - t if last else (t + h) - t
        error = attempt(t - origin, step, y, p, terms, scale, k, work, new)
        if not error <= 1.0:
            h = step * (0.2 if not error < 1e6 else max(0.2, 0.9 * error**-0.125))
            if h < SHORTEST_S:
                return STEP_TOO_SMALL, t, h, count, False
            continue
        project(new)
        rates(t - origin + step, new, p, terms, k[12])
        prepare_dense(t - origin, step, y, new, p, terms, k, work, dense)
        _store(pieces[count], t, step, y, p, dense, work, nodal, powers)
        count += 1
        grow = 6.0 if error == 0.0 else min(6.0, 0.9 * error**-0.125)
        h = max(h, step * grow) if last else step * grow
        t = end if last else t + step
        y[:] = new
        k[0] = k[12]
    return FINISHED, t, h, count, False


def tolerances(omega_rad_per_s: float) -> NDArray[np.float64]:
    """Tolerated error per step of each component of the state: (STATES,) float64."""
    scale = np.full(STATES, SIDE_TOLERANCE)
    scale[[Q, Q + 3, OMEGA + 2]] = TOLERANCE  # turns about w
    scale[N_DOT:Q] *= omega_rad_per_s
    scale[OMEGA:] *= omega_rad_per_s
    return scale


def move(
    start_s: float,
    stop_s: float,
    state: NDArray[np.float64],
    p: NDArray[np.float64],
    omega_rad_per_s: float,
    terms: NDArray[np.float64] = NO_FIELD,
) -> Motion:
    """The motion of a state (STATES,) from `start_s` to `stop_s`, s.

    p: see `acceleration`; omega_rad_per_s: of the main mode, limits the step; terms: of the field, (n, 6), times from
    `start_s`.  `internal_state` of the result is the state at the end, (STATES,); its pieces have RIGID_PIECE_SLOTS,
    phi is the angle of the moment about w.  Raises DeviceError if the step becomes too small.
    """
    rows = int((stop_s - start_s) * omega_rad_per_s / STEP_ANGLE_RAD * (8.0 if p[JEWEL] else 1.2)) + 64
    pieces = np.empty((rows, RIGID_PIECE_SLOTS))
    y = state.copy()
    t = start_s
    h = FIRST_STEP_S
    count = 0
    scale = tolerances(omega_rad_per_s)
    most = MOST_STEPS * rows
    while True:
        reason, t, h, count, stuck = march(t, stop_s, start_s, h, omega_rad_per_s, y, p, terms, scale, pieces, count)
        if reason == FINISHED:
            phi, phi_dot, *_ = azimuth(y, p)
            return Motion(
                pieces=pieces[:count].copy(),
                phi_rad=phi,
                phi_dot_rad_per_s=phi_dot,
                stuck=stuck,
                internal_state=y,
            )
        if reason == STEP_TOO_SMALL or not np.all(np.isfinite(y)) or len(pieces) > most:
            raise DeviceError(
                "the simulated rotor's motion cannot be followed",
                where="simulated world",
                why=f"the step became too small at {t} s",
                remedy="check damping, friction, defects and field in the configuration and the specimen",
            )
        pieces = np.concatenate([pieces, np.empty_like(pieces)])
