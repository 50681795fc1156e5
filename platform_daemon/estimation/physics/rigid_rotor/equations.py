"""Newton's and Euler's equations of a spherical rotor on a thread or in a jewel's cup.

Axes u, v, w of the resonator, origin at the stator's nominal place, SI.  Both bearings hold a point of the rotor at
the distance L from an anchor A: a thread (L: its length) the pole of the rotor that it is glued to, a jewel
(L = R - r) the rotor's centre.  That point is A + L (x, y, -z), z = sqrt(1 - x^2 - y^2).

State, (13,): x, y, their rates (1/s), unit vector of the moment, unit vector of the rotor's axis (from the centre to
the thread's end; a jewel's rotor has none), angular velocity (rad/s).  A unit vector e of the rotor moves by
de/dt = omega x e; a homogeneous sphere needs no more of its orientation.

The force of the bearing, tension or load, follows from the acceleration along the link being that of a circle.  A
jewel's contact rolls, slips and spins: coupled friction of a Hertz contact in Zhuravlev's Pade form, whose limits are
T_f of eq:tf(phi) without slip and Coulomb's law without spin.
"""

from __future__ import annotations

import math

from platform_daemon.estimation.numerics.jit import part
from platform_daemon.estimation.thresholds import THRESHOLDS

STATES = 13
MOMENT, AXIS, OMEGA = 4, 7, 10

# Parameters of the kernels, (SLOTS,).
JEWEL, MASS, INERTIA, LINK, RADIUS = 0, 1, 2, 3, 4
ANCHOR, STATOR, STATOR_MOMENT = 5, 8, 11  # (3,) each
MOMENT_SIZE, WEIGHT = 14, 15  # A m^2; (3,) N
DAMPING, SIDE_DAMPING, FRICTION, HERTZ, CREEP, CREEP_SPIN = 18, 19, 20, 21, 22, 23
CREEP_LAW, LEAN_DAMPING, DAMPING_AXIS = 24, 25, 26
SLOTS = 27

# Field of the coils, (DRIVE_SLOTS,): amplitude along u, v, w, T; rad/s, phase of the current; time constant and end, s.
FIELD, PULSATION, PHASE, LAG, END = 0, 3, 4, 5, 6
DRIVE_SLOTS = 7

PERMEABILITY = 1e-7  # mu_0 / (4 pi), T m/A
SPIN_LEVER = 3.0 * math.pi / 16.0  # eq:tf
SLIP_BY_SPIN, SPIN_BY_SLIP = 8.0 / (3.0 * math.pi), 15.0 * math.pi / 16.0  # Zhuravlev's coefficients
SLOWEST_SPIN = THRESHOLDS.rigid_rotor.slowest_spin_rad_per_s
SETTLED = 40.0  # time constants after which nothing is left of a transient


@part
def drive_strength(t, drive):  # type: ignore[no-untyped-def]
    """Coil current over its amplitude: a sine that begins from zero at t = 0 and decays after its end."""
    lag = drive[LAG]
    inside = min(t, drive[END])
    level = math.sin(drive[PULSATION] * inside + drive[PHASE])
    if lag > 0.0 and inside < SETTLED * lag:
        level -= math.sin(drive[PHASE]) * math.exp(-inside / lag)
    if t <= drive[END]:
        return level
    late = t - drive[END]
    return level * math.exp(-late / lag) if lag > 0.0 and late < SETTLED * lag else 0.0


@part
def _magnets(y, p, cx, cy, cz, bx, by, bz):  # type: ignore[no-untyped-def]
    """Force with weight, N, and torque, N m, on the rotor with its centre at c under the coils' field b, T."""
    ex, ey, ez = cx - p[8], cy - p[9], cz - p[10]
    square = ex * ex + ey * ey + ez * ez
    distance = math.sqrt(square)
    ex, ey, ez = ex / distance, ey / distance, ez / distance
    sx, sy, sz = p[11], p[12], p[13]
    mx, my, mz = p[14] * y[4], p[14] * y[5], p[14] * y[6]
    se = sx * ex + sy * ey + sz * ez
    me = mx * ex + my * ey + mz * ez
    unit = PERMEABILITY / (square * distance)
    bx += unit * (3.0 * se * ex - sx)
    by += unit * (3.0 * se * ey - sy)
    bz += unit * (3.0 * se * ez - sz)
    pull = 3.0 * unit / distance
    rest = mx * sx + my * sy + mz * sz - 5.0 * se * me
    fx = pull * (me * sx + se * mx + rest * ex) + p[15]
    fy = pull * (me * sy + se * my + rest * ey) + p[16]
    fz = pull * (me * sz + se * mz + rest * ez) + p[17]
    return fx, fy, fz, my * bz - mz * by, mz * bx - mx * bz, mx * by - my * bx


@part
def _friction(load, slip, spin, p):  # type: ignore[no-untyped-def]
    """Friction force per slip, N s/m, and torque per spin, N m s, of the contact under a load, N."""
    if load <= 0.0 or p[20] == 0.0:
        return 0.0, 0.0
    radius = p[21] * load ** (1.0 / 3.0)
    most = p[20] * load
    slow = p[24]
    rest = SLOWEST_SPIN * SLOWEST_SPIN
    turning = (1.0 - slow) * math.sqrt(spin * spin + p[23] * p[23] + rest)
    turning += slow * (math.sqrt(spin * spin + rest) + p[23])
    creeping = (1.0 - slow) * math.sqrt(slip * slip + p[22] * p[22]) + slow * (slip + abs(p[22]))
    by_slip = most / (creeping + SLIP_BY_SPIN * radius * turning)
    return by_slip, SPIN_LEVER * radius * most / (turning + SPIN_BY_SLIP * slip / radius)


@part
def rates(t, y, p, drive, out):  # type: ignore[no-untyped-def]
    """Write d/dt of the state y (STATES,) into out."""
    length, radius, mass, inertia = p[3], p[4], p[1], p[2]
    x, q, vx, vq = y[0], y[1], y[2], y[3]
    z = math.sqrt(1.0 - x * x - q * q)
    vz = -(x * vx + q * vq) / z  # rate of z
    nx, ny, nz = -x, -q, z  # from the held point to the anchor
    hx, hy, hz = length * vx, length * vq, -length * vz  # velocity of the held point
    wx, wy, wz = y[10], y[11], y[12]
    level = drive_strength(t, drive)
    bx, by, bz = level * drive[0], level * drive[1], level * drive[2]
    circling = (hx * hx + hy * hy + hz * hz) / length
    cx, cy, cz = p[5] + length * x, p[6] + length * q, p[7] - length * z
    if p[0] == 0.0:
        ax, ay, az = y[7], y[8], y[9]
        rx, ry, rz = wy * az - wz * ay, wz * ax - wx * az, wx * ay - wy * ax  # rate of the axis
        fx, fy, fz, tx, ty, tz = _magnets(y, p, cx - radius * ax, cy - radius * ay, cz - radius * az, bx, by, bz)
        loss = 2.0 * mass * p[19]
        fx -= loss * (hx - radius * rx)
        fy -= loss * (hy - radius * ry)
        fz -= loss * (hz - radius * rz)
        lx, ly, lz = ax + p[26] * (nx - ax), ay + p[26] * (ny - ay), az + p[26] * (nz - az)
        about = 2.0 * inertia * (p[18] - p[25]) * (wx * lx + wy * ly + wz * lz) / (lx * lx + ly * ly + lz * lz)
        loss = 2.0 * inertia * p[25]
        tx -= loss * wx + about * lx
        ty -= loss * wy + about * ly
        tz -= loss * wz + about * lz
        ix, iy, iz = wy * rz - wz * ry, wz * rx - wx * rz, wx * ry - wy * rx  # omega x (omega x axis)
        kx, ky, kz = (ty * az - tz * ay) / inertia, (tz * ax - tx * az) / inertia, (tx * ay - ty * ax) / inertia
        cosine = ax * nx + ay * ny + az * nz
        along = nx * (kx + ix) + ny * (ky + iy) + nz * (kz + iz)
        tension = mass * (circling - radius * along) - (nx * fx + ny * fy + nz * fz)
        tension /= 1.0 + mass * radius * radius * (1.0 - cosine * cosine) / inertia
        lever = radius * tension
        gx = (tx + lever * (ay * nz - az * ny)) / inertia
        gy = (ty + lever * (az * nx - ax * nz)) / inertia
        gz = (tz + lever * (ax * ny - ay * nx)) / inertia
        pull_x = (fx + tension * nx) / mass + radius * (gy * az - gz * ay + ix)
        pull_y = (fy + tension * ny) / mass + radius * (gz * ax - gx * az + iy)
        out[7], out[8], out[9] = rx, ry, rz
    else:
        fx, fy, fz, tx, ty, tz = _magnets(y, p, cx, cy, cz, bx, by, bz)
        loss = 2.0 * mass * p[19]
        fx, fy, fz = fx - loss * hx, fy - loss * hy, fz - loss * hz
        spin = wx * nx + wy * ny + wz * nz
        load = mass * circling - (nx * fx + ny * fy + nz * fz)
        sx = hx - radius * (wy * nz - wz * ny)  # velocity of the surface at the contact
        sy = hy - radius * (wz * nx - wx * nz)
        sz = hz - radius * (wx * ny - wy * nx)
        by_slip, by_spin = _friction(load, math.sqrt(sx * sx + sy * sy + sz * sz), abs(spin), p)
        sx, sy, sz = -by_slip * sx, -by_slip * sy, -by_slip * sz
        about = (2.0 * inertia * (p[18] - p[25]) + by_spin) * spin
        loss = 2.0 * inertia * p[25]
        gx = (tx - loss * wx - about * nx - radius * (ny * sz - nz * sy)) / inertia
        gy = (ty - loss * wy - about * ny - radius * (nz * sx - nx * sz)) / inertia
        gz = (tz - loss * wz - about * nz - radius * (nx * sy - ny * sx)) / inertia
        pull_x = (fx + load * nx + sx) / mass
        pull_y = (fy + load * ny + sy) / mass
        out[7], out[8], out[9] = 0.0, 0.0, 0.0
    out[0], out[1] = vx, vq
    out[2], out[3] = pull_x / length, pull_y / length
    out[4] = wy * y[6] - wz * y[5]
    out[5] = wz * y[4] - wx * y[6]
    out[6] = wx * y[5] - wy * y[4]
    out[10], out[11], out[12] = gx, gy, gz
