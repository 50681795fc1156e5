"""Newton's and Euler's equations of a spherical rotor on a thread or in a jewel's cup.

Axes u, v, w of the resonator, origin at the stator's nominal place, SI.  Both bearings hold a point of the rotor at
the distance L from an anchor A: a thread (L: its length) the pole of the rotor that it is glued to, a jewel
(L = R - r) the rotor's centre.  That point is A + L (x, y, -z), z = sqrt(1 - x^2 - y^2).

State, (13,): x, y, their rates (1/s), unit vector of the moment, unit vector of the rotor's axis (from the centre to
the thread's end; a jewel's rotor has none), angular velocity (rad/s).  A unit vector e of the rotor moves by
de/dt = omega x e; a homogeneous sphere needs no more of its orientation.

The force of the bearing, tension or load, follows from the acceleration along the link being that of a circle.  A
jewel's contact rolls, slips and spins: coupled friction of a Hertz contact, exactly or in Zhuravlev's Pade form, whose
limits are T_f of eq:tf(phi) without slip and Coulomb's law without spin.
"""

from __future__ import annotations

import math

from platform_daemon.estimation.numerics.jit import fast_part, lane_part
from platform_daemon.estimation.thresholds import THRESHOLDS

STATES = 13
MOMENT, AXIS, OMEGA = 4, 7, 10
LANES = 4

# Parameters of the kernels, (SLOTS,).
JEWEL, MASS, INERTIA, LINK, RADIUS = 0, 1, 2, 3, 4
ANCHOR, STATOR, STATOR_MOMENT = 5, 8, 11  # (3,) each
MOMENT_SIZE, WEIGHT = 14, 15  # A m^2; (3,) N
DAMPING, SIDE_DAMPING, FRICTION, HERTZ, CREEP, CREEP_SPIN = 18, 19, 20, 21, 22, 23
CREEP_LAW, LEAN_DAMPING, DAMPING_AXIS, USUAL_LOAD_ROOT = 24, 25, 26, 27  # cube root of the load at rest, N^(1/3)
CONTACT_COUPLING = 28
SLOTS = 29

# Field of the coils, (DRIVE_SLOTS,): amplitude along u, v, w, T; rad/s, phase of the current; time constant and end, s.
FIELD, PULSATION, PHASE, LAG, END = 0, 3, 4, 5, 6
DRIVE_SLOTS = 7

# Rows of `lanes`, each of LANES numbers: state, parameters, amplitude of the coils' field, d/dt of the state, and the
# load of a jewel, N.
STATE, PARAMETER, COILS, RATE = 0, STATES, STATES + SLOTS, STATES + SLOTS + 3
LOAD = RATE + STATES
ROWS = LOAD + 1

PERMEABILITY = 1e-7  # mu_0 / (4 pi), T m/A
SPIN_LEVER = 3.0 * math.pi / 16.0  # eq:tf
SLIP_BY_SPIN, SPIN_BY_SLIP = 8.0 / (3.0 * math.pi), 15.0 * math.pi / 16.0  # Zhuravlev's coefficients
SLIDES_0, SLIDES_1, SLIDES_2 = THRESHOLDS.rigid_rotor.slides_bent
TURNS_0, TURNS_1, TURNS_2 = THRESHOLDS.rigid_rotor.turns_bent
# Of a disc that slips as fast as its edge spins: force less mu N, and torque over mu N a, and what makes their slopes.
FORCE_ALIKE, TORQUE_ALIKE = 0.75 / SLIP_BY_SPIN - 1.0, 0.375 * SPIN_LEVER
FORCE_SLOPE, TORQUE_SLOPE = FORCE_ALIKE + 0.125 / SLIP_BY_SPIN, 0.5 * TORQUE_ALIKE - 0.25 * SPIN_LEVER
FORCE_4, FORCE_5, FORCE_6, FORCE_7, FORCE_8, FORCE_9 = THRESHOLDS.rigid_rotor.slipping_force
TORQUE_4, TORQUE_5, TORQUE_6, TORQUE_7, TORQUE_8, TORQUE_9 = THRESHOLDS.rigid_rotor.slipping_torque
SLOWEST_SPIN = THRESHOLDS.rigid_rotor.slowest_spin_rad_per_s
SLOWEST_EDGE = 1e-30  # m/s, so small that it changes nothing, and its powers are numbers
SLOWEST_SLIP = 1e-12  # m/s, likewise, of a slip whose tangent is taken
NOTHING = 1e-300  # keeps what a contact without friction divides by from being 0
ROOT_ROUNDS = 4  # of Halley's method: from a load eight times off to the last digit
SETTLED = 40.0  # time constants after which nothing is left of a transient


@fast_part
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


@lane_part
def at(lanes, row, lane):  # type: ignore[no-untyped-def]
    """One number of a row."""
    return lanes[row * LANES + lane]


@lane_part
def three(lanes, row, lane):  # type: ignore[no-untyped-def]
    """A vector that begins in a row."""
    return lanes[row * LANES + lane], lanes[(row + 1) * LANES + lane], lanes[(row + 2) * LANES + lane]


@lane_part
def _magnets(lanes, lane, level, cx, cy, cz):  # type: ignore[no-untyped-def]
    """Force with weight, N, and torque, N m, on the rotor with its centre at c while the coils' current is `level`."""
    ox, oy, oz = three(lanes, PARAMETER + STATOR, lane)
    ex, ey, ez = cx - ox, cy - oy, cz - oz
    square = ex * ex + ey * ey + ez * ez
    distance = math.sqrt(square)
    ex, ey, ez = ex / distance, ey / distance, ez / distance
    sx, sy, sz = three(lanes, PARAMETER + STATOR_MOMENT, lane)
    moment = at(lanes, PARAMETER + MOMENT_SIZE, lane)
    mx, my, mz = three(lanes, STATE + MOMENT, lane)
    mx, my, mz = moment * mx, moment * my, moment * mz
    se = sx * ex + sy * ey + sz * ez
    me = mx * ex + my * ey + mz * ez
    unit = PERMEABILITY / (square * distance)
    bx, by, bz = three(lanes, COILS, lane)
    bx = level * bx + unit * (3.0 * se * ex - sx)
    by = level * by + unit * (3.0 * se * ey - sy)
    bz = level * bz + unit * (3.0 * se * ez - sz)
    pull = 3.0 * unit / distance
    rest = mx * sx + my * sy + mz * sz - 5.0 * se * me
    gx, gy, gz = three(lanes, PARAMETER + WEIGHT, lane)
    fx = pull * (me * sx + se * mx + rest * ex) + gx
    fy = pull * (me * sy + se * my + rest * ey) + gy
    fz = pull * (me * sz + se * mz + rest * ez) + gz
    return fx, fy, fz, my * bz - mz * by, mz * bx - mx * bz, mx * by - my * bx


@lane_part
def contact_radius(lanes, lane, load):  # type: ignore[no-untyped-def]
    """Radius of the contact under a load, m.

    It goes with the cube root of the load: Halley's method from the root at rest, which a lane can do.
    """
    pressed = max(load, 0.0)
    root = at(lanes, PARAMETER + USUAL_LOAD_ROOT, lane)
    for _ in range(ROOT_ROUNDS):
        cube = root * root * root
        root *= (cube + 2.0 * pressed) / (2.0 * cube + pressed)
    return at(lanes, PARAMETER + HERTZ, lane) * root


@lane_part
def laws_shares(law):  # type: ignore[no-untyped-def]
    """1 for the law of a contact that there is, and 0 for the others: 1, 2, 3 and 4; all are 0 for the law 0."""
    return (
        max(0.0, 1.0 - abs(law - 1.0)),
        max(0.0, 1.0 - abs(law - 2.0)),
        max(0.0, 1.0 - abs(law - 3.0)),
        max(0.0, 1.0 - abs(law - 4.0)),
    )


@lane_part
def over_tanh(x):  # type: ignore[no-untyped-def]
    """1 / tanh(x) of an x above 0, good to 1e-9 of it.

    A continued fraction of an eighth of x, doubled three times; beyond 24 the tangent is 1 to the last digit.
    """
    u = 0.125 * min(x, 24.0)
    square = u * u
    above, below = u * (945.0 + square * (105.0 + square)), 945.0 + square * (420.0 + 15.0 * square)
    for _ in range(3):
        above, below = 2.0 * above * below, above * above + below * below
    return below / above


@lane_part
def slipping_disc(k):  # type: ignore[no-untyped-def]
    """Force over mu N, and torque over 3 pi/16 mu N a, of a disc under Hertz's pressure with Coulomb's friction.

    k: slip over the speed of the edge by the spin.  The friction is the derivative of one potential, the integral of
    pressure times speed over the disc: up to k = 1, where a point of the disc is at rest, polynomials, beyond closed
    forms with arcsin(1/k), of which these are approximations that lanes can do.
    """
    slow = min(k, 1.0)
    square = slow * slow
    spins = slow / SLIP_BY_SPIN * (1.0 - 0.25 * square), 1.0 - square + 0.375 * square * square
    share = 1.0 / max(k, 1.0)
    y = share * share
    x = math.sqrt(1.0 - y)
    force = FORCE_4 + x * (FORCE_5 + x * (FORCE_6 + x * (FORCE_7 + x * (FORCE_8 + x * FORCE_9))))
    force = 1.0 + y * (FORCE_ALIKE + x * x * (FORCE_SLOPE + x * x * force))
    torque = TORQUE_4 + x * (TORQUE_5 + x * (TORQUE_6 + x * (TORQUE_7 + x * (TORQUE_8 + x * TORQUE_9))))
    torque = share * (TORQUE_ALIKE + x * x * (TORQUE_SLOPE + x * x * torque))
    return spins[0] if k < 1.0 else force, spins[1] if k < 1.0 else torque / SPIN_LEVER


@lane_part
def _friction(lanes, lane, load, slip, spin):  # type: ignore[no-untyped-def]
    """Friction force per slip, N s/m, and torque per spin, N m s, of the contact under a load, N.

    Where each point of the disc creeps as v / sqrt(v^2 + c^2), the exact limits of slip alone, of spin alone and of a
    slow spin beside a slip, beta q / (1 + c^2 / q^2) with q^2 = slip^2 + c^2, are joined by the root of their squares.
    Alone, each is good to 1e-3; where slip and spin are alike, the force is up to 14 % too small, the torque 20 %.
    That of the law 3, where only the whole disc creeps, is exact, and so is that of the law 4, whose whole disc creeps
    by the hyperbolic tangent of slip and edge, the root of their squares, over c, or without coupling of each alone.
    """
    radius = contact_radius(lanes, lane, load)
    most = at(lanes, PARAMETER + FRICTION, lane) * max(load, 0.0)
    creep, creep_spin = at(lanes, PARAMETER + CREEP, lane), at(lanes, PARAMETER + CREEP_SPIN, lane)
    sums, at_points, on_disc, by_tanh = laws_shares(at(lanes, PARAMETER + CREEP_LAW, lane))
    rest = SLOWEST_SPIN * SLOWEST_SPIN
    bare = math.sqrt(spin * spin + rest)
    turning = (1.0 - sums) * math.sqrt(spin * spin + creep_spin * creep_spin + rest) + sums * (bare + creep_spin)
    creeping = (1.0 - sums) * math.sqrt(slip * slip + creep * creep) + sums * (slip + abs(creep))
    coupling = at(lanes, PARAMETER + CONTACT_COUPLING, lane)
    slowed, beside = coupling * SLIP_BY_SPIN * radius, coupling * SPIN_BY_SLIP
    square = slip * slip + creep * creep + NOTHING
    whirled, pressed_on = slowed * spin, radius * spin
    stuck = beside * square * math.sqrt(square) / (square + creep * creep)
    jointly = 1.0 - at_points - on_disc - by_tanh
    slides = jointly * (creeping + slowed * turning)
    share = whirled * whirled / (square + whirled * whirled)
    bent = 1.0 + share * (1.0 - share) * (SLIDES_0 + share * (SLIDES_1 + share * SLIDES_2))
    slides += at_points * bent * math.sqrt(square + whirled * whirled)
    turns = jointly * (radius * turning + beside * slip)
    share = pressed_on * pressed_on / (pressed_on * pressed_on + stuck * stuck + NOTHING)
    bent = 1.0 + share * (1.0 - share) * (TURNS_0 + share * (TURNS_1 + share * TURNS_2))
    turns += at_points * bent * math.sqrt(pressed_on * pressed_on + stuck * stuck)
    # The disc of the law 3, or that of the law 4, which does not creep but by the tangent.
    creeps = 1.0 - by_tanh
    slid = math.sqrt(slip * slip + creeps * creep * creep + SLOWEST_SLIP * SLOWEST_SLIP)
    edge = abs(radius) * math.sqrt(spin * spin + creeps * creep_spin * creep_spin + rest) + SLOWEST_EDGE
    force, torque = slipping_disc(slid / edge)
    alone = 1.0 - coupling
    whole = math.sqrt(slid * slid + edge * edge)
    slow = over_tanh((coupling * whole + alone * slid) / (abs(creep) + SLOWEST_EDGE))
    disc = on_disc + by_tanh * coupling * slow
    slides += disc * slid / force
    turns += disc * math.copysign(edge, radius) / torque
    slides += by_tanh * alone * slid * slow
    turns += by_tanh * alone * radius * bare * over_tanh(bare / (abs(creep_spin) + SLOWEST_SPIN))
    return most / (slides + NOTHING), SPIN_LEVER * radius * radius * most / (turns + NOTHING)


@fast_part
def _jewel_rates(level, lanes):  # type: ignore[no-untyped-def]
    """The rates of rotors in cups, of which the held point is the centre."""
    for lane in range(LANES):
        mass, inertia = at(lanes, PARAMETER + MASS, lane), at(lanes, PARAMETER + INERTIA, lane)
        length, radius = at(lanes, PARAMETER + LINK, lane), at(lanes, PARAMETER + RADIUS, lane)
        x, q, vx = three(lanes, STATE, lane)
        vq = at(lanes, STATE + 3, lane)
        z = math.sqrt(1.0 - x * x - q * q)
        vz = -(x * vx + q * vq) / z  # rate of z
        nx, ny, nz = -x, -q, z  # from the held point to the anchor
        hx, hy, hz = length * vx, length * vq, -length * vz  # velocity of the held point
        wx, wy, wz = three(lanes, STATE + OMEGA, lane)
        ox, oy, oz = three(lanes, PARAMETER + ANCHOR, lane)
        fx, fy, fz, tx, ty, tz = _magnets(lanes, lane, level, ox + length * x, oy + length * q, oz - length * z)
        loss = 2.0 * mass * at(lanes, PARAMETER + SIDE_DAMPING, lane)
        fx, fy, fz = fx - loss * hx, fy - loss * hy, fz - loss * hz
        spin = wx * nx + wy * ny + wz * nz
        load = mass * (hx * hx + hy * hy + hz * hz) / length - (nx * fx + ny * fy + nz * fz)
        sx = hx - radius * (wy * nz - wz * ny)  # velocity of the surface at the contact
        sy = hy - radius * (wz * nx - wx * nz)
        sz = hz - radius * (wx * ny - wy * nx)
        by_slip, by_spin = _friction(lanes, lane, load, math.sqrt(sx * sx + sy * sy + sz * sz), abs(spin))
        sx, sy, sz = -by_slip * sx, -by_slip * sy, -by_slip * sz
        lean_damping = at(lanes, PARAMETER + LEAN_DAMPING, lane)
        about = (2.0 * inertia * (at(lanes, PARAMETER + DAMPING, lane) - lean_damping) + by_spin) * spin
        loss = 2.0 * inertia * lean_damping
        gx = (tx - loss * wx - about * nx - radius * (ny * sz - nz * sy)) / inertia
        gy = (ty - loss * wy - about * ny - radius * (nz * sx - nx * sz)) / inertia
        gz = (tz - loss * wz - about * nz - radius * (nx * sy - ny * sx)) / inertia
        pull_x = (fx + load * nx + sx) / (mass * length)
        pull_y = (fy + load * ny + sy) / (mass * length)
        lanes[LOAD * LANES + lane] = load
        _write(lanes, lane, vx, vq, pull_x, pull_y, 0.0, 0.0, 0.0, wx, wy, wz, gx, gy, gz)


@fast_part
def _thread_rates(level, lanes):  # type: ignore[no-untyped-def]
    """The rates of rotors on threads, of which the held point is a pole."""
    for lane in range(LANES):
        mass, inertia = at(lanes, PARAMETER + MASS, lane), at(lanes, PARAMETER + INERTIA, lane)
        length, radius = at(lanes, PARAMETER + LINK, lane), at(lanes, PARAMETER + RADIUS, lane)
        x, q, vx = three(lanes, STATE, lane)
        vq = at(lanes, STATE + 3, lane)
        z = math.sqrt(1.0 - x * x - q * q)
        vz = -(x * vx + q * vq) / z  # rate of z
        nx, ny, nz = -x, -q, z  # from the held point to the anchor
        hx, hy, hz = length * vx, length * vq, -length * vz  # velocity of the held point
        wx, wy, wz = three(lanes, STATE + OMEGA, lane)
        ax, ay, az = three(lanes, STATE + AXIS, lane)
        rx, ry, rz = wy * az - wz * ay, wz * ax - wx * az, wx * ay - wy * ax  # rate of the axis
        ox, oy, oz = three(lanes, PARAMETER + ANCHOR, lane)
        cx, cy, cz = ox + length * x - radius * ax, oy + length * q - radius * ay, oz - length * z - radius * az
        fx, fy, fz, tx, ty, tz = _magnets(lanes, lane, level, cx, cy, cz)
        loss = 2.0 * mass * at(lanes, PARAMETER + SIDE_DAMPING, lane)
        fx -= loss * (hx - radius * rx)
        fy -= loss * (hy - radius * ry)
        fz -= loss * (hz - radius * rz)
        to_thread = at(lanes, PARAMETER + DAMPING_AXIS, lane)
        lx, ly, lz = ax + to_thread * (nx - ax), ay + to_thread * (ny - ay), az + to_thread * (nz - az)
        lean_damping = at(lanes, PARAMETER + LEAN_DAMPING, lane)
        about = 2.0 * inertia * (at(lanes, PARAMETER + DAMPING, lane) - lean_damping)
        about *= (wx * lx + wy * ly + wz * lz) / (lx * lx + ly * ly + lz * lz)
        loss = 2.0 * inertia * lean_damping
        tx -= loss * wx + about * lx
        ty -= loss * wy + about * ly
        tz -= loss * wz + about * lz
        ix, iy, iz = wy * rz - wz * ry, wz * rx - wx * rz, wx * ry - wy * rx  # omega x (omega x axis)
        kx, ky, kz = (ty * az - tz * ay) / inertia, (tz * ax - tx * az) / inertia, (tx * ay - ty * ax) / inertia
        cosine = ax * nx + ay * ny + az * nz
        along = nx * (kx + ix) + ny * (ky + iy) + nz * (kz + iz)
        circling = (hx * hx + hy * hy + hz * hz) / length
        tension = mass * (circling - radius * along) - (nx * fx + ny * fy + nz * fz)
        tension /= 1.0 + mass * radius * radius * (1.0 - cosine * cosine) / inertia
        lever = radius * tension
        gx = (tx + lever * (ay * nz - az * ny)) / inertia
        gy = (ty + lever * (az * nx - ax * nz)) / inertia
        gz = (tz + lever * (ax * ny - ay * nx)) / inertia
        pull_x = ((fx + tension * nx) / mass + radius * (gy * az - gz * ay + ix)) / length
        pull_y = ((fy + tension * ny) / mass + radius * (gz * ax - gx * az + iy)) / length
        _write(lanes, lane, vx, vq, pull_x, pull_y, rx, ry, rz, wx, wy, wz, gx, gy, gz)


@lane_part
def _write(lanes, lane, vx, vq, pull_x, pull_y, rx, ry, rz, wx, wy, wz, gx, gy, gz):  # type: ignore[no-untyped-def]
    """The rates into their rows; the moment turns with the rotor."""
    mx, my, mz = three(lanes, STATE + MOMENT, lane)
    lanes[(RATE + 0) * LANES + lane], lanes[(RATE + 1) * LANES + lane] = vx, vq
    lanes[(RATE + 2) * LANES + lane], lanes[(RATE + 3) * LANES + lane] = pull_x, pull_y
    lanes[(RATE + MOMENT) * LANES + lane] = wy * mz - wz * my
    lanes[(RATE + MOMENT + 1) * LANES + lane] = wz * mx - wx * mz
    lanes[(RATE + MOMENT + 2) * LANES + lane] = wx * my - wy * mx
    lanes[(RATE + AXIS) * LANES + lane] = rx
    lanes[(RATE + AXIS + 1) * LANES + lane] = ry
    lanes[(RATE + AXIS + 2) * LANES + lane] = rz
    lanes[(RATE + OMEGA) * LANES + lane] = gx
    lanes[(RATE + OMEGA + 1) * LANES + lane] = gy
    lanes[(RATE + OMEGA + 2) * LANES + lane] = gz


@fast_part
def rates(t, drive, lanes):  # type: ignore[no-untyped-def]
    """Write d/dt of the states into their rows of `lanes` (ROWS * LANES,)."""
    level = drive_strength(t, drive)
    if lanes[(PARAMETER + JEWEL) * LANES] != 0.0:
        _jewel_rates(level, lanes)
    else:
        _thread_rates(level, lanes)
