"""Integrates the motion of the rotor in pieces that end exactly at every turning point, with sticking and release.

Between two turning points the sign of phi' is constant, so the equation phi'' = drive - sgn(phi') friction is smooth
and a step of `collocation` is exact to rounding error.  A step h in which phi' changes sign is shortened: the velocity
polynomial of the step brackets the zero, and Newton's method in h makes phi' vanish at the end.  There the rotor sticks
while |drive| <= friction, until the field releases it, or continues in the direction of the drive.  A tanh in place of
the sign, or steps across a turning point, would cause errors of 1e-5 rad.
"""

from __future__ import annotations

from math import cos, sin

import numpy as np
from numpy.typing import NDArray

from drivers.errors import DeviceError

from .collocation import INTERNAL_NOW, INTERNAL_ROWS, INTERNAL_START, solve_step, to_powers
from .extra_torque import DRIFT, DRIFT_FROM
from .internal_state import relaxed
from .kernel import kernel
from .pieces import NO_FIELD, NODES, PIECE_SLOTS, Motion
from .rest import NOISE, release_s
from .torque import drive, friction, has_kinks

FINISHED, BUFFER_FULL, NO_CONVERGENCE = 0, 1, 2
STEP_ANGLE_RAD = 0.2
TAIL = 1e-10  # largest relative size of the last polynomial term in a step
STILL = 1e-14  # of omega_nat: a smaller velocity counts as zero
SHORTEST_S = 1e-10
MOST_STEPS = 200  # limit of the steps, as a multiple of those of a free swing


@kernel
def _store(row, start, h, phi, phi_dot, angle, speed, accel, work):  # type: ignore[no-untyped-def]
    row[0] = start
    row[1] = h
    row[2] = phi
    row[3] = phi_dot
    to_powers(accel, row[4 : 4 + NODES])
    for i in range(NODES):
        work[i] = -speed[i] * sin(angle[i])
    to_powers(work, row[4 + NODES : 4 + 2 * NODES])
    for i in range(NODES):
        work[i] = speed[i] * cos(angle[i])
    to_powers(work, row[4 + 2 * NODES : 4 + 3 * NODES])


@kernel
def _resolved(accel: NDArray[np.float64], work: NDArray[np.float64], noise: float) -> bool:
    """True if the polynomial's last two terms are negligible, so that the piece is accurate inside as well."""
    to_powers(accel, work)
    size = 0.0
    for i in range(NODES):
        size = max(size, abs(accel[i]))
    last = abs(work[7]) / 64.0
    return last <= TAIL * size + noise and last + abs(work[6]) / 32.0 <= 100.0 * TAIL * size + noise


@kernel
def _crossing(phi_dot, h, sign, still, accel, work):  # type: ignore[no-untyped-def]
    """First fraction (0, 1] of the step at which the velocity polynomial changes sign; 2 if there is none."""
    to_powers(accel, work)
    low = 0.0
    high = 2.0
    for k in range(1, 65):
        if sign * _speed_at(phi_dot, h, k / 32.0 - 1.0, work) < -still:
            high = k / 64.0
            break
        low = k / 64.0
    if high == 2.0:
        return high
    for _ in range(60):
        middle = 0.5 * (low + high)
        if sign * _speed_at(phi_dot, h, 2.0 * middle - 1.0, work) < 0.0:
            high = middle
        else:
            low = middle
    return high


@kernel
def _speed_at(phi_dot: float, h: float, x: float, powers: NDArray[np.float64]) -> float:
    total = 0.0
    edge = -1.0
    power = x
    for k in range(NODES):
        total += powers[k] * (power - edge) / (k + 1)
        power *= x
        edge = -edge
    return phi_dot + 0.5 * h * total


@kernel
def _loses_sign(sign: float, still: float, end_speed: float, speed: NDArray[np.float64]) -> bool:
    lost = sign * end_speed < -still
    for i in range(NODES):
        lost = lost or sign * speed[i] < -still
    return lost


@kernel
def _turn(tau, h, phi, phi_dot, sign, q, terms, angle, speed, accel, internal_state):  # type: ignore[no-untyped-def]
    """Shorten the step by Newton's method until the velocity at its end vanishes; returns its length and end angle."""
    phi_1 = phi
    for _ in range(5):
        _, phi_1, left = solve_step(tau, h, phi, phi_dot, sign, q, terms, angle, speed, accel, internal_state)
        push = drive(tau + h, phi_1, left, q, terms, internal_state[INTERNAL_NOW])
        slope = push - sign * friction(tau + h, phi_1, sign * left, q)
        if slope * sign >= 0.0 or left == 0.0 or abs(left) >= 0.1 * h * abs(slope):
            break
        h -= left / slope
    return h, phi_1


@kernel
def march(start, end, origin, phi, phi_dot, q, terms, pieces, count, internal_state):  # type: ignore[no-untyped-def]
    """Advance the state from `start` to `end` (s), writing pieces from row `count` on.

    origin: time zero of the field terms, s; internal_state: (INTERNAL_ROWS, states), its row INTERNAL_START is updated.
    Returns (reason, time reached, phi, phi_dot, rows used, stuck at the end).
    """
    angle, speed, accel, work = np.zeros(NODES), np.zeros(NODES), np.zeros(NODES), np.zeros(NODES)
    kinks = has_kinks(q)
    h_max = STEP_ANGLE_RAD / np.sqrt(q[1])
    still = STILL * np.sqrt(q[1])
    h_now = h_max
    t = start
    stuck = False
    while t < end:
        if count >= pieces.shape[0]:
            return BUFFER_FULL, t, phi, phi_dot, count, stuck
        stuck = False
        sign = np.sign(phi_dot)
        if kinks and abs(phi_dot) <= still:
            push = drive(t - origin, phi, 0.0, q, terms, internal_state[INTERNAL_START])
            sign = np.sign(push)
            if abs(push) <= friction(t - origin, phi, 0.0, q) + NOISE * q[1]:
                phi_dot = 0.0
                free = min(origin + release_s(t - origin, end - origin, phi, q, terms, internal_state), end)
                stuck = free >= end
                if free > t:
                    pieces[count, :] = 0.0
                    pieces[count, 0] = t
                    pieces[count, 1] = free - t
                    pieces[count, 2] = phi
                    count += 1
                    t = free
                    continue
        h = (t + min(h_now, end - t)) - t
        last = t + 1.01 * h >= end
        if last:
            h = end - t
        ok, phi_1, phi_dot_1 = solve_step(
            t - origin, h, phi, phi_dot, sign, q, terms, angle, speed, accel, internal_state
        )
        if h > SHORTEST_S and not (ok and _resolved(accel, work, NOISE * q[1])):
            h_now = 0.5 * h
            accel[:] = 0.0
            internal_state[:NODES] = 0.0
            continue
        if not ok:
            return NO_CONVERGENCE, t, phi, phi_dot, count, stuck
        if kinks and _loses_sign(sign, still, phi_dot_1, speed):
            part = _crossing(phi_dot, h, sign, still, accel, work)
            if part <= 1.0:
                h, phi_1 = _turn(
                    t - origin, part * h, phi, phi_dot, sign, q, terms, angle, speed, accel, internal_state
                )
                phi_dot_1 = 0.0
                last = False
        _store(pieces[count], t, h, phi, phi_dot, angle, speed, accel, work)
        count += 1
        t = end if last else t + h
        phi = phi_1
        phi_dot = phi_dot_1
        internal_state[INTERNAL_START] = internal_state[INTERNAL_NOW]
        h_now = min(2.0 * max(h_now, h), h_max)
    return FINISHED, t, phi, phi_dot, count, stuck


def move(
    start_s: float,
    stop_s: float,
    phi_rad: float,
    phi_dot_rad_per_s: float,
    q: NDArray[np.float64],
    terms: NDArray[np.float64] = NO_FIELD,
    internal_state: NDArray[np.float64] | None = None,
) -> Motion:
    """The motion from `start_s` to `stop_s`, s.

    q: see `torque.parameters`; terms: of the field, (n, 5), times from `start_s`, see `torque.field`; internal_state:
    at the start, (STATES,); None or empty: relaxed.  Raises DeviceError if the step becomes too small (damping or
    stiffness far beyond physical values).

    >>> motion = move(0.0, 1.0, phi_rad=0.5, phi_dot_rad_per_s=0.0, q=parameters(rotor))
    """
    rows = int((stop_s - start_s) * np.sqrt(q[1]) / STEP_ANGLE_RAD * 1.2) + 64
    pieces = np.empty((rows, PIECE_SLOTS))
    z = _step_buffer(relaxed(q) if internal_state is None or not internal_state.size else internal_state)
    t, phi, speed, count, stuck = start_s, phi_rad, phi_dot_rad_per_s, 0, False
    kink_s = start_s + q[DRIFT_FROM]
    ends = [kink_s, stop_s] if q[DRIFT] != 0.0 and start_s < kink_s < stop_s else [stop_s]
    while True:
        reason, t, phi, speed, count, stuck = march(t, ends[0], start_s, phi, speed, q, terms, pieces, count, z)
        if reason == FINISHED and len(ends) > 1:
            del ends[0]
            continue
        if reason == FINISHED:
            return Motion(
                pieces=pieces[:count],
                phi_rad=phi,
                phi_dot_rad_per_s=speed,
                stuck=stuck,
                internal_state=z[INTERNAL_START].copy(),
            )
        if reason == NO_CONVERGENCE or len(pieces) > MOST_STEPS * rows:
            raise DeviceError(
                "the simulated rotor's motion cannot be followed",
                where="simulated world",
                why=f"the step became too small at {t} s",
                remedy="check damping, friction and field in the configuration and the specimen",
            )
        pieces = np.concatenate([pieces, np.empty_like(pieces)])


def _step_buffer(internal_state: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rows of a step's internal state, (INTERNAL_ROWS, states), with start and present value set."""
    buffer = np.zeros((INTERNAL_ROWS, internal_state.size))
    buffer[INTERNAL_START] = buffer[INTERNAL_NOW] = internal_state
    return buffer
