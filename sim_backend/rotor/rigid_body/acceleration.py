"""Equations of motion of the rigid rotor with five degrees of freedom, as numba kernels.

All vectors are in the resonator's own axes u, v, w (fig:mmr-definitions): origin at the stator's nominal position, w
along the nominal main axis, -u along the nominal stator moment.  SI throughout.  Both bearings constrain one point of
the rotor to a sphere of radius L about the anchor A, at A - L n: the thread its end on the rotor's surface (L: its
length), the jewel the rotor's centre (L = R - r, paper sec. ssec:manufacturing_errors_side_modes).  So the state of
both is n, n', the orientation of the rotor as a quaternion, and its angular velocity.
"""

from __future__ import annotations

from math import cos, exp, pi, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.constants import mu_0

from sim_backend.rotor.kernel import kernel

# State: (STATES,) float64: n, n' (1/s), quaternion w x y z (body to u, v, w), angular velocity (rad/s; u, v, w).
N, N_DOT, Q, OMEGA = 0, 3, 6, 10
STATES = 13

# Parameters: (SLOTS,) float64.
JEWEL = 0  # 1: jewel, 0: thread
MASS, INERTIA, LINK, ARM = 1, 2, 3, 4  # kg, kg m^2, L m, r m (thread: from the centre to its end)
ANCHOR, STATOR = 5, 8  # m
STATOR_MOMENT, BODY_MOMENT = 11, 14  # A m^2; in u, v, w; in the body
WEIGHT = 17  # N
DAMPING, SIDE_DAMPING = 20, 21  # 1/s: amplitude decay of the main mode, lambda (eq:lambda), and of the side modes
MU, HERTZ, SLOWEST_SLIP, SLOWEST_SPIN = 22, 23, 24, 25  # 1, m/N^(1/3), m/s, rad/s
BACK = 26  # T^2/(A V), (3, 3) of the closed loops by rows: back-action
SLOTS = 35

# Terms of the drive field: those of `rotor.torque`, b_u, b_v, omega, phase, rate, with b_w as a sixth.
MU_0_OVER_4_PI = mu_0 / (4 * pi)


@kernel
def turned(y, x0, x1, x2):  # type: ignore[no-untyped-def]
    """A vector of the body in u, v, w, by the quaternion of the state."""
    a, b, c, d = y[6], y[7], y[8], y[9]
    t0 = 2.0 * (c * x2 - d * x1)
    t1 = 2.0 * (d * x0 - b * x2)
    t2 = 2.0 * (b * x1 - c * x0)
    return x0 + a * t0 + c * t2 - d * t1, x1 + a * t1 + d * t0 - b * t2, x2 + a * t2 + b * t1 - c * t0


@kernel
def dipole(p, c0, c1, c2, m0, m1, m2):  # type: ignore[no-untyped-def]
    """Force on a dipole m at c, and the stator's field there: 3 + 3 float, N and T."""
    s0, s1, s2 = p[11], p[12], p[13]
    x0, x1, x2 = c0 - p[8], c1 - p[9], c2 - p[10]
    square = x0 * x0 + x1 * x1 + x2 * x2
    distance = sqrt(square)
    x0, x1, x2 = x0 / distance, x1 / distance, x2 / distance
    sx = s0 * x0 + s1 * x1 + s2 * x2
    mx = m0 * x0 + m1 * x1 + m2 * x2
    level = MU_0_OVER_4_PI / (square * distance)
    pull = 3.0 * level / distance
    along = m0 * s0 + m1 * s1 + m2 * s2 - 5.0 * sx * mx
    return (
        pull * (mx * s0 + sx * m0 + along * x0),
        pull * (mx * s1 + sx * m1 + along * x1),
        pull * (mx * s2 + sx * m2 + along * x2),
        level * (3.0 * sx * x0 - s0),
        level * (3.0 * sx * x1 - s1),
        level * (3.0 * sx * x2 - s2),
    )


@kernel
def drive_field(tau: float, terms: NDArray[np.float64]) -> tuple[float, float, float]:
    """Coil field at the rotor along u, v, w, T, `tau` seconds after the terms' time zero; terms: (n, 6)."""
    b_u = 0.0
    b_v = 0.0
    b_w = 0.0
    for i in range(terms.shape[0]):
        shape = cos(terms[i, 2] * tau + terms[i, 3])
        if terms[i, 4] != 0.0:
            shape *= exp(-terms[i, 4] * tau)
        b_u += terms[i, 0] * shape
        b_v += terms[i, 1] * shape
        b_w += terms[i, 5] * shape
    return b_u, b_v, b_w


@kernel
def magnetic(tau, y, p, terms, c0, c1, c2):  # type: ignore[no-untyped-def]
    """Force (weight included) and torque on the rotor with its centre at c, without friction: 3 + 3 float, N, N m."""
    m0, m1, m2 = turned(y, p[14], p[15], p[16])
    f0, f1, f2, b0, b1, b2 = dipole(p, c0, c1, c2, m0, m1, m2)
    if terms.shape[0] > 0:
        d0, d1, d2 = drive_field(tau, terms)
        b0, b1, b2 = b0 + d0, b1 + d1, b2 + d2
    if p[26] != 0.0 or p[30] != 0.0 or p[34] != 0.0:
        w0, w1, w2 = y[10], y[11], y[12]
        r0, r1, r2 = w1 * m2 - w2 * m1, w2 * m0 - w0 * m2, w0 * m1 - w1 * m0
        b0 -= p[26] * r0 + p[27] * r1 + p[28] * r2
        b1 -= p[29] * r0 + p[30] * r1 + p[31] * r2
        b2 -= p[32] * r0 + p[33] * r1 + p[34] * r2
    return f0 + p[17], f1 + p[18], f2 + p[19], m1 * b2 - m2 * b1, m2 * b0 - m0 * b2, m0 * b1 - m1 * b0


@kernel
def _thread(tau, y, p, terms, out):  # type: ignore[no-untyped-def]
    """Write n'' and omega' on a massless rigid thread between ball joints into out (STATES,)."""
    link, arm, mass, inertia = p[3], p[4], p[1], p[2]
    n0, n1, n2 = y[0], y[1], y[2]
    w0, w1, w2 = y[10], y[11], y[12]
    a0, a1, a2 = turned(y, 0.0, 0.0, 1.0)  # from the centre to the end of the thread
    v0, v1, v2 = w1 * a2 - w2 * a1, w2 * a0 - w0 * a2, w0 * a1 - w1 * a0
    c0, c1, c2 = p[5] - link * n0 - arm * a0, p[6] - link * n1 - arm * a1, p[7] - link * n2 - arm * a2
    f0, f1, f2, t0, t1, t2 = magnetic(tau, y, p, terms, c0, c1, c2)
    drag = 2.0 * p[21] * mass
    f0 += drag * (link * y[3] + arm * v0)
    f1 += drag * (link * y[4] + arm * v1)
    f2 += drag * (link * y[5] + arm * v2)
    spin = w0 * a0 + w1 * a1 + w2 * a2
    more = 2.0 * inertia * (p[20] - p[21]) * spin
    drag = 2.0 * inertia * p[21]
    t0 -= drag * w0 + more * a0
    t1 -= drag * w1 + more * a1
    t2 -= drag * w2 + more * a2
    # acceleration of the thread's end without tension: f/m + arm (omega' x a + omega x (omega x a))
    e0 = f0 / mass + arm * ((t1 * a2 - t2 * a1) / inertia + w1 * v2 - w2 * v1)
    e1 = f1 / mass + arm * ((t2 * a0 - t0 * a2) / inertia + w2 * v0 - w0 * v2)
    e2 = f2 / mass + arm * ((t0 * a1 - t1 * a0) / inertia + w0 * v1 - w1 * v0)
    an = a0 * n0 + a1 * n1 + a2 * n2
    wanted = link * (y[3] * y[3] + y[4] * y[4] + y[5] * y[5])
    tension = (wanted - e0 * n0 - e1 * n1 - e2 * n2) / (1.0 / mass + arm * arm / inertia * (1.0 - an * an))
    lever = arm * tension / inertia
    out[10] = t0 / inertia + lever * (a1 * n2 - a2 * n1)
    out[11] = t1 / inertia + lever * (a2 * n0 - a0 * n2)
    out[12] = t2 / inertia + lever * (a0 * n1 - a1 * n0)
    turn = arm * lever
    straight = tension / mass + turn
    out[3] = -(e0 + straight * n0 - turn * an * a0) / link
    out[4] = -(e1 + straight * n1 - turn * an * a1) / link
    out[5] = -(e2 + straight * n2 - turn * an * a2) / link


@kernel
def contact(load, slip, spin, p):  # type: ignore[no-untyped-def]
    """Friction of the Hertz contact: force per slip velocity (N s/m) and torque per spin (N m s), both >= 0.

    load, N; slip, m/s; spin, rad/s, both >= 0.  This is Zhuravlev's Pade approximation of a Hertz contact that slides
    and spins at the same time; its limit without slip is eq:tf(phi), without spin Coulomb's law.  The two slowest
    speeds regularise rest: below them the contact creeps.
    """
    if load <= 0.0 or p[22] == 0.0:
        return 0.0, 0.0
    radius = p[23] * load ** (1.0 / 3.0)
    level = p[22] * load
    spin = sqrt(spin * spin + p[25] * p[25])
    force = level / (sqrt(slip * slip + p[24] * p[24]) + 8.0 / (3.0 * pi) * radius * spin)
    return force, 3.0 * pi / 16.0 * radius * level / (spin + 15.0 * pi / 16.0 * slip / radius)


@kernel
def _jewel(tau, y, p, terms, out):  # type: ignore[no-untyped-def]
    """Write n'' and omega' of the sphere that rolls, slips and spins in its cup into out (STATES,)."""
    link, arm, mass, inertia = p[3], p[4], p[1], p[2]
    n0, n1, n2 = y[0], y[1], y[2]
    w0, w1, w2 = y[10], y[11], y[12]
    f0, f1, f2, t0, t1, t2 = magnetic(tau, y, p, terms, p[5] - link * n0, p[6] - link * n1, p[7] - link * n2)
    drag = 2.0 * p[21] * mass * link
    f0, f1, f2 = f0 + drag * y[3], f1 + drag * y[4], f2 + drag * y[5]
    spin = w0 * n0 + w1 * n1 + w2 * n2
    load = mass * link * (y[3] * y[3] + y[4] * y[4] + y[5] * y[5]) - (f0 * n0 + f1 * n1 + f2 * n2)
    # velocity of the rotor's surface at the contact: C' - r omega x n
    s0 = -link * y[3] - arm * (w1 * n2 - w2 * n1)
    s1 = -link * y[4] - arm * (w2 * n0 - w0 * n2)
    s2 = -link * y[5] - arm * (w0 * n1 - w1 * n0)
    per_slip, per_spin = contact(load, sqrt(s0 * s0 + s1 * s1 + s2 * s2), abs(spin), p)
    s0, s1, s2 = -per_slip * s0, -per_slip * s1, -per_slip * s2
    more = 2.0 * inertia * (p[20] - p[21]) * spin + per_spin * spin
    drag = 2.0 * inertia * p[21]
    out[10] = (t0 - drag * w0 - more * n0 - arm * (n1 * s2 - n2 * s1)) / inertia
    out[11] = (t1 - drag * w1 - more * n1 - arm * (n2 * s0 - n0 * s2)) / inertia
    out[12] = (t2 - drag * w2 - more * n2 - arm * (n0 * s1 - n1 * s0)) / inertia
    out[3] = -(f0 + load * n0 + s0) / (mass * link)
    out[4] = -(f1 + load * n1 + s1) / (mass * link)
    out[5] = -(f2 + load * n2 + s2) / (mass * link)


@kernel
def rates(tau, y, p, terms, out):  # type: ignore[no-untyped-def]
    """Write d/dt of the state y (STATES,) into out; tau: time on the axis of the field terms (n, 6), s."""
    for i in range(3):
        out[i] = y[3 + i]
    a, b, c, d = y[6], y[7], y[8], y[9]
    w0, w1, w2 = 0.5 * y[10], 0.5 * y[11], 0.5 * y[12]
    out[6] = -w0 * b - w1 * c - w2 * d
    out[7] = w0 * a + w1 * d - w2 * c
    out[8] = w1 * a + w2 * b - w0 * d
    out[9] = w2 * a + w0 * c - w1 * b
    if p[0] == 0.0:
        _thread(tau, y, p, terms, out)
    else:
        _jewel(tau, y, p, terms, out)


@kernel
def project(y: NDArray[np.float64]) -> None:
    """Normalise n and the quaternion and make n' perpendicular to n, in place."""
    size = sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2])
    for i in range(3):
        y[i] /= size
    along = y[0] * y[3] + y[1] * y[4] + y[2] * y[5]
    for i in range(3):
        y[3 + i] -= along * y[i]
    size = sqrt(y[6] * y[6] + y[7] * y[7] + y[8] * y[8] + y[9] * y[9])
    for i in range(6, 10):
        y[i] /= size
