"""Integration of the rigid rotor: the explicit method of order 5(4) by Dormand and Prince with dense output.

A motion chooses its steps by the estimated error.  Neighbours in parameter space are computed at the steps of the first
one, so that differences between them hold no noise of the choice of steps.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import RK45

from platform_daemon.estimation.numerics.jit import kernel, part
from platform_daemon.estimation.thresholds import THRESHOLDS

from .equations import END, OMEGA, STATES, rates

LIMITS = THRESHOLDS.rigid_rotor
STAGES = 7  # with the one that is the first of the next step
A, B, C, E, DENSE = (np.ascontiguousarray(table) for table in (RK45.A, RK45.B, RK45.C, RK45.E, RK45.P))
ORDERS = DENSE.shape[1]
FIRST_STEP = LIMITS.first_step
SAFETY, SHRINK, GROW = LIMITS.safety, LIMITS.shrink, LIMITS.grow
SHORTEST_S, FAILED, LAST_STEP = LIMITS.shortest_step_s, LIMITS.failed_error, LIMITS.last_step_share
MOST_STEPS_PER_S = LIMITS.most_steps_per_s


@kernel
def accelerations(y, p, drive):  # type: ignore[no-untyped-def]
    """d/dt of the state y at t = 0, (STATES,)."""
    out = np.empty(STATES)
    rates(0.0, y, p, drive, out)
    return out


@part
def _attempt(t, h, y, p, drive, k, work, new):  # type: ignore[no-untyped-def]
    """A step from y into `new`; k: (STAGES, STATES), row 0 given, the last row becomes the rates at the end."""
    for stage in range(1, STAGES - 1):
        for i in range(STATES):
            total = 0.0
            for j in range(stage):
                total += A[stage, j] * k[j, i]
            work[i] = y[i] + h * total
        rates(t + C[stage] * h, work, p, drive, k[stage])
    for i in range(STATES):
        total = 0.0
        for j in range(STAGES - 1):
            total += B[j] * k[j, i]
        new[i] = y[i] + h * total
    rates(t + h, new, p, drive, k[STAGES - 1])


@part
def _error(h, k, scale):  # type: ignore[no-untyped-def]
    """Estimated error of the step relative to the tolerance."""
    squares = 0.0
    for i in range(STATES):
        total = 0.0
        for j in range(STAGES):
            total += E[j] * k[j, i]
        squares += (h * total / scale[i]) ** 2
    return math.sqrt(squares)


@part
def _sample(y, h, x, k, out):  # type: ignore[no-untyped-def]
    """Write omega x moment at the fraction x of the step into out (3,)."""
    place = np.empty(6)
    for n in range(6):
        i = 4 + n if n < 3 else OMEGA + n - 3
        total = 0.0
        for j in range(STAGES):
            weight = 0.0
            for order in range(ORDERS - 1, -1, -1):
                weight = (weight + DENSE[j, order]) * x
            total += weight * k[j, i]
        place[n] = y[i] + h * total
    mx, my, mz, wx, wy, wz = place
    out[0] = wy * mz - wz * my
    out[1] = wz * mx - wx * mz
    out[2] = wx * my - wy * mx


@kernel
def swing(y, p, drive, first_s, step_s, scale, given, out):  # type: ignore[no-untyped-def]
    """Motion from state y at t = 0, the start of the drive; fills out (n, 3) with d(moment/m_r)/dt along u, v, w, 1/s.

    first_s, step_s: time of the first sample and distance of the samples; scale: (STATES,) tolerated error per step;
    given: ends of the steps of another motion, (0,): they are chosen.  Returns the ends of the steps; they are fewer
    than the samples need if the motion cannot be followed.
    """
    n = out.shape[0]
    end = max(first_s + n * step_s, drive[END])  # a sample more: neighbours may be sampled a little later
    k, work, new = np.empty((STAGES, STATES)), np.empty(STATES), np.empty(STATES)
    now = y.copy()
    ends = np.empty(1024 if given.size == 0 else given.size)
    count, sample = 0, 0
    t, h = 0.0, FIRST_STEP * step_s
    rates(t, now, p, drive, k[0])
    while t < end:
        if given.size > 0:
            if count >= given.size:
                break
            stop = given[count]
        else:
            limit = drive[END] if t < drive[END] else end
            stop = limit if t + h > limit or limit - (t + h) < LAST_STEP * h else t + h
        length = stop - t
        _attempt(t, length, now, p, drive, k, work, new)
        if given.size == 0:
            error = _error(length, k, scale)
            if not error <= 1.0:
                h = length * (SHRINK if not error < FAILED else max(SHRINK, SAFETY * error**-0.2))
                if h < SHORTEST_S:
                    break
                continue
            grow = GROW if error == 0.0 else min(GROW, SAFETY * error**-0.2)
            h = max(h, length * grow) if length < h else length * grow
        while sample < n and first_s + sample * step_s <= stop:
            at = first_s + sample * step_s
            if at >= t:
                _sample(now, length, (at - t) / length, k, out[sample])
            sample += 1
        if count > MOST_STEPS_PER_S * end:
            break
        if count == ends.size:
            more = np.empty(2 * count)
            more[:count] = ends
            ends = more
        ends[count] = stop
        count += 1
        t = stop
        now[:] = new
        if not math.isfinite(now[0]):
            break
        if stop == drive[END]:
            rates(t, now, p, drive, k[0])
        else:
            k[0] = k[STAGES - 1]
    return ends[:count]
