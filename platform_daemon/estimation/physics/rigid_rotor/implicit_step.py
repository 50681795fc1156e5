"""Steps of a jewel's rotor: linearly implicit Euler steps in its contact's friction, extrapolated.

Where a contact creeps only below a small slip c, friction takes the slip back at a rate of mu load / (mass c): 1e6 per
second where the swing has 1.3e3.  An explicit method must follow that rate, whatever its order.  A linearly implicit
step with h solves (1 - h A) dy = h f(y), where A is the derivative of the friction by slip and spin alone: in closed
form, along the slip and of the spin together, and across the slip.  Its result has an expansion in powers of h, so that
those with H, H/2, ..., H/K extrapolate to order K (Deuflhard, SIAM Review 27, 505 (1985)); the last two columns tell
the error.
"""

from __future__ import annotations

import math

from platform_daemon.estimation.numerics.jit import fast_part, lane_part
from platform_daemon.estimation.thresholds import THRESHOLDS

from .equations import (
    CONTACT_COUPLING,
    CREEP,
    CREEP_LAW,
    CREEP_SPIN,
    FRICTION,
    INERTIA,
    LANES,
    LINK,
    LOAD,
    MASS,
    MOMENT,
    NOTHING,
    OMEGA,
    PARAMETER,
    RADIUS,
    RATE,
    SLIP_BY_SPIN,
    SLOWEST_EDGE,
    SLOWEST_SLIP,
    SLOWEST_SPIN,
    SPIN_BY_SLIP,
    SPIN_LEVER,
    STATE,
    STATES,
    at,
    contact_radius,
    laws_shares,
    over_tanh,
    rates,
    slipping_disc,
    three,
)

STATE_SIZE = STATES * LANES
ORDER = THRESHOLDS.rigid_rotor.sticking_order


@lane_part
def disc_slopes(k):  # type: ignore[no-untyped-def]
    """Derivatives by k of what `slipping_disc` gives; beyond k = 1 between those there and in the end."""
    slow, share = min(k, 1.0), 1.0 / max(k, 1.0)
    force, torque = (1.0 - 0.75 * slow * slow) / SLIP_BY_SPIN, (1.5 * slow * slow - 2.0) * slow
    y = share * share
    beyond = share * y * (0.25 * y / SLIP_BY_SPIN + 0.2 * (1.0 - y))
    falls = -y * (0.5 * y + 0.2 * (1.0 - y) / SPIN_LEVER)
    return force if k < 1.0 else beyond, torque if k < 1.0 else falls


@lane_part
def _friction_slopes(lanes, lane, load, slip, spin):  # type: ignore[no-untyped-def]
    """Friction force per slip, N s/m, its derivatives by slip and by spin, and those of the torque by slip and by spin.

    The laws are those of `equations._friction`.
    """
    radius = contact_radius(lanes, lane, load)
    most = at(lanes, PARAMETER + FRICTION, lane) * max(load, 0.0)
    creep, creep_spin = at(lanes, PARAMETER + CREEP, lane), at(lanes, PARAMETER + CREEP_SPIN, lane)
    law, coupling = at(lanes, PARAMETER + CREEP_LAW, lane), at(lanes, PARAMETER + CONTACT_COUPLING, lane)
    sums, at_points, on_disc, by_tanh = laws_shares(law)
    jointly = 1.0 - at_points - on_disc - by_tanh
    rest = SLOWEST_SPIN * SLOWEST_SPIN
    smooth, bare = math.sqrt(spin * spin + creep_spin * creep_spin + rest), math.sqrt(spin * spin + rest)
    turning = (1.0 - sums) * smooth + sums * (bare + creep_spin)
    turning_slope = (1.0 - sums) * spin / smooth + sums * spin / bare
    crept = math.sqrt(slip * slip + creep * creep) + NOTHING
    creeping = (1.0 - sums) * crept + sums * (slip + abs(creep))
    creeping_slope = (1.0 - sums) * slip / crept + sums
    slowed, beside = coupling * SLIP_BY_SPIN * radius, coupling * SPIN_BY_SLIP
    square = slip * slip + creep * creep + NOTHING
    both = square + creep * creep
    stuck = beside * square * math.sqrt(square) / both
    stuck_slope = beside * slip * math.sqrt(square) * (both + 2.0 * creep * creep) / (both * both)
    slides_there = math.sqrt(square + slowed * slowed * spin * spin)  # what bends them by 4 % stays explicit
    turns_there = math.sqrt(radius * radius * spin * spin + stuck * stuck) + NOTHING
    reach, side = abs(radius), math.copysign(1.0, radius)
    creeps = 1.0 - by_tanh
    slid = math.sqrt(slip * slip + creeps * creep * creep + SLOWEST_SLIP * SLOWEST_SLIP)
    smooth = math.sqrt(spin * spin + creeps * creep_spin * creep_spin + rest)
    edge = reach * smooth + SLOWEST_EDGE
    # 1 / tanh of what creeps by it, and its derivative: -1 / sinh^2
    whole = math.sqrt(slid * slid + edge * edge)
    c, c_spin = abs(creep) + SLOWEST_EDGE, abs(creep_spin) + SLOWEST_SPIN
    slow, slow_spin = over_tanh((coupling * whole + (1.0 - coupling) * slid) / c), over_tanh(bare / c_spin)
    falls, falls_spin = (1.0 - slow * slow) / c, (1.0 - slow_spin * slow_spin) / c_spin
    coupled, alone = by_tanh * coupling, by_tanh * (1.0 - coupling)
    disc = on_disc + coupled * slow
    force, torque = slipping_disc(slid / edge)
    force_slope, torque_slope = disc_slopes(slid / edge)
    by_k = force_slope * slid / (force * force), side * torque_slope * edge / (torque * torque)
    k_by_slip, k_by_spin = slip / (slid * edge), -slid * reach * spin / (smooth * edge * edge)
    slides = jointly * (creeping + slowed * turning) + at_points * slides_there + disc * slid / force + NOTHING
    slides += alone * slid * slow
    turns = (
        jointly * (radius * turning + beside * slip)
        + at_points * turns_there
        + disc * side * edge / torque
        + alone * radius * bare * slow_spin
        + NOTHING
    )
    slides_by_slip = jointly * creeping_slope + at_points * slip / slides_there
    slides_by_slip += disc * (slip / (slid * force) - by_k[0] * k_by_slip)
    slides_by_slip += coupled * falls * slip / whole * slid / force + alone * (slow + slid * falls)
    slides_by_spin = jointly * slowed * turning_slope + at_points * slowed * slowed * spin / slides_there
    slides_by_spin -= disc * by_k[0] * k_by_spin
    slides_by_spin += coupled * falls * reach * reach * spin / whole * slid / force
    turns_by_spin = jointly * radius * turning_slope + at_points * radius * radius * spin / turns_there
    turns_by_spin += disc * (side * reach * spin / (smooth * torque) - by_k[1] * k_by_spin)
    turns_by_spin += coupled * falls * reach * reach * spin / whole * side * edge / torque
    turns_by_spin += alone * radius * spin / bare * (slow_spin + bare * falls_spin)
    turns_by_slip = jointly * beside + at_points * stuck * stuck_slope / turns_there
    turns_by_slip -= disc * by_k[1] * k_by_slip
    turns_by_slip += coupled * falls * slip / whole * side * edge / torque
    by_slip, by_spin = most / slides, SPIN_LEVER * radius * radius * most / turns
    return (
        by_slip,
        by_slip * (1.0 - slip * slides_by_slip / slides),
        -by_slip * slip * slides_by_spin / slides,
        -by_spin * spin * turns_by_slip / turns,
        by_spin * (1.0 - spin * turns_by_spin / turns),
    )


@fast_part
def _taken_implicitly(h, lanes):  # type: ignore[no-untyped-def]
    """Add to the rates of rotors in cups what a step of h changes their friction by: (1 - h A)^-1 f in place of f.

    The slip changes with the velocities, and with the place in the cup, whose new one an Euler step knows beforehand.
    """
    for lane in range(LANES):
        mass, inertia = at(lanes, PARAMETER + MASS, lane), at(lanes, PARAMETER + INERTIA, lane)
        length, radius = at(lanes, PARAMETER + LINK, lane), at(lanes, PARAMETER + RADIUS, lane)
        x, q, vx = three(lanes, STATE, lane)
        vq = at(lanes, STATE + 3, lane)
        z = math.sqrt(1.0 - x * x - q * q)
        vz = -(x * vx + q * vq) / z
        nx, ny, nz = -x, -q, z
        wx, wy, wz = three(lanes, STATE + OMEGA, lane)
        spin = wx * nx + wy * ny + wz * nz
        sx = length * vx - radius * (wy * nz - wz * ny)  # the slip
        sy = length * vq - radius * (wz * nx - wx * nz)
        sz = -length * vz - radius * (wx * ny - wy * nx)
        slip = math.sqrt(sx * sx + sy * sy + sz * sz)
        load = at(lanes, LOAD, lane)
        across, force_slip, force_spin, torque_slip, torque_spin = _friction_slopes(lanes, lane, load, slip, abs(spin))
        rx, ry = at(lanes, RATE + 2, lane), at(lanes, RATE + 3, lane)
        gx, gy, gz = three(lanes, RATE + OMEGA, lane)
        # By how much the slip (d) and the spin would change over h by the rates as they are.
        rz = (x * rx + q * ry + vx * vx + vq * vq + vz * vz) / z
        dx = h * (length * rx - radius * (gy * nz - gz * ny + wy * vz + wz * vq))
        dy = h * (length * ry - radius * (gz * nx - gx * nz - wz * vx - wx * vz))
        dz = h * (length * rz - radius * (gx * ny - gy * nx - wx * vq + wy * vx))
        turned = h * (gx * nx + gy * ny + gz * nz - wx * vx - wy * vq + wz * vz)
        unit = 1.0 / (slip + NOTHING)
        sx, sy, sz = unit * sx, unit * sy, unit * sz
        along = dx * sx + dy * sy + dz * sz
        dx, dy, dz = dx - along * sx, dy - along * sy, dz - along * sz
        # What is left of it: along the slip and of the spin two equations together, across the slip one.
        lightness = h * (1.0 / mass + radius * radius / inertia)
        sign = math.copysign(1.0, spin)
        a11, a12 = 1.0 + lightness * force_slip, lightness * sign * force_spin
        a21, a22 = h / inertia * sign * torque_slip, 1.0 + h / inertia * torque_spin
        determinant = a11 * a22 - a12 * a21
        along, turned = (along * a22 - a12 * turned) / determinant, (a11 * turned - a21 * along) / determinant
        force = force_slip * along + sign * force_spin * turned
        across /= 1.0 + lightness * across
        fx, fy, fz = -force * sx - across * dx, -force * sy - across * dy, -force * sz - across * dz
        torque = sign * torque_slip * along + torque_spin * turned
        lanes[(RATE + 2) * LANES + lane] = rx + fx / (mass * length)
        lanes[(RATE + 3) * LANES + lane] = ry + fy / (mass * length)
        lanes[(RATE + OMEGA) * LANES + lane] = gx - (torque * nx + radius * (ny * fz - nz * fy)) / inertia
        lanes[(RATE + OMEGA + 1) * LANES + lane] = gy - (torque * ny + radius * (nz * fx - nx * fz)) / inertia
        lanes[(RATE + OMEGA + 2) * LANES + lane] = gz - (torque * nz + radius * (nx * fy - ny * fx)) / inertia


@fast_part
def implicit_step(t, length, now, drive, table, lanes):  # type: ignore[no-untyped-def]
    """A step from the states `now` (STATE_SIZE,), after which those of `lanes` are the new ones.

    table: (ORDER + 1, STATE_SIZE); its last row becomes the estimated errors.
    """
    for row in range(ORDER):
        h = length / (row + 1)
        for n in range(STATE_SIZE):
            lanes[n] = now[n]
        for part in range(row + 1):
            rates(t + part * h, drive, lanes)
            _taken_implicitly(h, lanes)
            for n in range(STATE_SIZE):
                lanes[n] += h * lanes[RATE * LANES + n]
        for n in range(STATE_SIZE):
            table[row, n] = lanes[n]
    for column in range(1, ORDER):
        for row in range(ORDER - 1, column - 1, -1):
            factor = (row + 1.0 - column) / column  # 1 / (ratio of the steps - 1)
            for n in range(STATE_SIZE):
                correction = factor * (table[row, n] - table[row - 1, n])
                table[row, n] += correction
                table[ORDER, n] = correction
    for n in range(STATE_SIZE):
        lanes[n] = table[ORDER - 1, n]


@fast_part
def between(now, length, x, before, lanes, lane, out):  # type: ignore[no-untyped-def]
    """Write omega x moment of a lane at the fraction x of the step into out (3,), by the cubic of both ends.

    before: (STATE_SIZE,) rates at the beginning; `lanes` holds states and rates at the end.
    """
    mx, my, mz = _cubic(now, length, x, before, lanes, MOMENT * LANES + lane)
    wx, wy, wz = _cubic(now, length, x, before, lanes, OMEGA * LANES + lane)
    out[0] = wy * mz - wz * my
    out[1] = wz * mx - wx * mz
    out[2] = wx * my - wy * mx


@fast_part
def _cubic(now, length, x, before, lanes, n):  # type: ignore[no-untyped-def]
    a, b = (1.0 + 2.0 * x) * (1.0 - x) ** 2, length * x * (1.0 - x) ** 2
    c, d = 1.0 - a, length * x * x * (x - 1.0)
    e = RATE * LANES
    return (
        a * now[n] + b * before[n] + c * lanes[n] + d * lanes[e + n],
        a * now[n + LANES] + b * before[n + LANES] + c * lanes[n + LANES] + d * lanes[e + n + LANES],
        a * now[n + 2 * LANES] + b * before[n + 2 * LANES] + c * lanes[n + 2 * LANES] + d * lanes[e + n + 2 * LANES],
    )
