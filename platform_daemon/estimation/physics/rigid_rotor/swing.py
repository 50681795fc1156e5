"""Integration of the rigid rotor: the explicit method of order 5(4) by Dormand and Prince with dense output, and for a
contact that takes slip back too fast for it the one of `implicit_step`.

A motion chooses its steps by the estimated error.  Its neighbours in parameter space, which are computed beside it or
later, take the same steps, so that differences between them hold no noise of the choice of steps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from scipy.integrate import RK45

from platform_daemon.estimation.numerics.jit import fast_kernel, fast_part
from platform_daemon.estimation.thresholds import THRESHOLDS

from .equations import COILS, DRIVE_SLOTS, END, LANES, LOAD, MOMENT, OMEGA, PARAMETER, RATE, ROWS, STATES, rates
from .implicit_step import ORDER, between, implicit_step

LIMITS = THRESHOLDS.rigid_rotor
T = TypeVar("T")
STAGES = 7  # with the one that is the first of the next step
E, DENSE = (np.ascontiguousarray(table) for table in (RK45.E, RK45.P))
WEIGHTS = np.vstack([np.pad(RK45.A, ((0, 0), (0, 1))), RK45.B])  # of the rates in each stage, the last one is the end
NODES = np.append(RK45.C, 1.0)
STATE_SIZE = STATES * LANES
ORDERS = DENSE.shape[1]
FIRST_STEP = LIMITS.first_step
SAFETY, SHRINK, GROW = LIMITS.safety, LIMITS.shrink, LIMITS.grow
SHORTEST_S, FAILED, LAST_STEP = LIMITS.shortest_step_s, LIMITS.failed_error, LIMITS.last_step_share
MOST_STEPS_PER_S, SETTLING_S = LIMITS.most_steps_per_s, LIMITS.settling_s


@fast_kernel
def accelerations(y, p):  # type: ignore[no-untyped-def]
    """d/dt of the states y, (STATES, LANES), without a drive; p: (SLOTS, LANES)."""
    lanes, out = np.zeros(ROWS * LANES), np.empty((STATES, LANES))
    _fill(lanes, 0, y)
    _fill(lanes, PARAMETER, p)
    rates(0.0, np.zeros(DRIVE_SLOTS), lanes)
    for row in range(STATES):
        for lane in range(LANES):
            out[row, lane] = lanes[(RATE + row) * LANES + lane]
    return out


@fast_part
def _fill(lanes, first, rows):  # type: ignore[no-untyped-def]
    """Write rows (k, LANES) into `lanes` from row `first` on."""
    for row in range(rows.shape[0]):
        for lane in range(LANES):
            lanes[(first + row) * LANES + lane] = rows[row, lane]


@fast_part
def _attempt(t, h, now, drive, k, lanes):  # type: ignore[no-untyped-def]
    """A step from the states `now`, after which those of `lanes` are the new ones.

    now: (STATES * LANES,); k: (STAGES, STATES * LANES), row 0 given, the last row becomes the rates at the end.
    """
    for stage in range(1, STAGES):
        for n in range(STATE_SIZE):
            lanes[n] = now[n]
        for j in range(stage):
            weight = h * WEIGHTS[stage, j]
            for n in range(STATE_SIZE):
                lanes[n] += weight * k[j, n]
        rates(t + NODES[stage] * h, drive, lanes)
        for n in range(STATE_SIZE):
            k[stage, n] = lanes[RATE * LANES + n]


@fast_part
def _error(t, h, k, scale, until_s):  # type: ignore[no-untyped-def]
    """Estimated error of a step from t relative to the tolerance, the largest of the lanes that choose it."""
    largest = 0.0
    for lane in range(LANES):
        if t >= until_s[lane]:
            continue
        squares = 0.0
        for i in range(STATES):
            total = 0.0
            for j in range(STAGES):
                total += E[j] * k[j, i * LANES + lane]
            squares += (h * total / scale[i]) ** 2
        if squares > largest or math.isnan(squares):
            largest = squares
    return math.sqrt(largest)


@fast_part
def _relative(t, errors, scale, until_s):  # type: ignore[no-untyped-def]
    """Estimated errors (STATE_SIZE,) of a step from t relative to the tolerance, the largest of those lanes."""
    largest = 0.0
    for lane in range(LANES):
        if t >= until_s[lane]:
            continue
        squares = 0.0
        for i in range(STATES):
            squares += (errors[i * LANES + lane] / scale[i]) ** 2
        if squares > largest or math.isnan(squares):
            largest = squares
    return math.sqrt(largest)


@fast_part
def _lost(t, now, until_s):  # type: ignore[no-untyped-def]
    """One of those lanes is no number."""
    lost = False
    for lane in range(LANES):
        lost |= t < until_s[lane] and not math.isfinite(now[lane])
    return lost


@fast_part
def _sample(now, h, x, k, lane, weight, out):  # type: ignore[no-untyped-def]
    """Write omega x moment of a lane at the fraction x of the step into out (3,); weight: (STAGES,), overwritten."""
    for j in range(STAGES):
        weight[j] = 0.0
        for order in range(ORDERS - 1, -1, -1):
            weight[j] = (weight[j] + DENSE[j, order]) * x
    mx, my, mz = _dense(now, h, k, MOMENT, lane, weight)
    wx, wy, wz = _dense(now, h, k, OMEGA, lane, weight)
    out[0] = wy * mz - wz * my
    out[1] = wz * mx - wx * mz
    out[2] = wx * my - wy * mx


@fast_part
def _dense(now, h, k, row, lane, weight):  # type: ignore[no-untyped-def]
    """A vector of the state within the step, that begins in a row."""
    n = row * LANES + lane
    x = y = z = 0.0
    for j in range(STAGES):
        x += weight[j] * k[j, n]
        y += weight[j] * k[j, n + LANES]
        z += weight[j] * k[j, n + 2 * LANES]
    return now[n] + h * x, now[n + LANES] + h * y, now[n + 2 * LANES] + h * z


@fast_part
def _sample_step(t, stop, now, k, lanes, first_s, step_s, sampled, implicit, out):  # type: ignore[no-untyped-def]
    """Fill in what is sampled from t to stop; sampled: (rows,) numbers of what is, which grow."""
    length, weight = stop - t, np.empty(STAGES)
    for row in range(out.shape[0]):
        lane = row if row < LANES else 0
        while sampled[row] < out.shape[1] and first_s[row] + sampled[row] * step_s <= stop:
            at = first_s[row] + sampled[row] * step_s
            if at >= t and implicit:
                between(now, length, (at - t) / length, k[0], lanes, lane, out[row, sampled[row]])
            elif at >= t:
                _sample(now, length, (at - t) / length, k, lane, weight, out[row, sampled[row]])
            sampled[row] += 1


@fast_kernel
def swings(y, p, coils, drive, first_s, step_s, scale, given, until_s, implicit, out):  # type: ignore[no-untyped-def]
    """Motions from states y at t = 0, the start of the drive; fills out (rows, n, 3) with d(moment/m_r)/dt, 1/s.

    Args:
        y: (STATES, LANES).
        p: (SLOTS, LANES).
        coils: (3, LANES) amplitude of the field along u, v, w, T.
        drive: (DRIVE_SLOTS,) of all lanes.
        first_s: (rows,) time of the first sample of each lane, and of more samples of the first lane.
        step_s: distance of the samples.
        scale: (STATES,) tolerated error per step.
        given: ends of the steps of another motion; (0,): they are chosen.
        until_s: (LANES,) time until which they are short enough for each lane.
        implicit: rotors in cups, whose friction is taken implicitly.
        out: along u, v, w.

    Returns:
        The ends of the steps; they are fewer than the samples need if a motion that chooses them cannot be followed.
    """
    samples = out.shape[1]
    end = max(first_s.max() + samples * step_s, drive[END])
    k, now = np.empty((STAGES, STATE_SIZE)), np.empty(STATE_SIZE)
    lanes, sampled = np.zeros(ROWS * LANES), np.zeros(out.shape[0], np.int64)
    _fill(lanes, 0, y)
    _fill(lanes, PARAMETER, p)
    _fill(lanes, COILS, coils)
    now[:] = lanes[:STATE_SIZE]
    ends = np.empty(given.size if given.size > 0 else samples)
    table, power = np.zeros((ORDER + 1, STATE_SIZE)), -1.0 / ORDER if implicit else -0.2
    count, t, h = 0, 0.0, FIRST_STEP * step_s
    rates(t, drive, lanes)
    k[0] = lanes[RATE * LANES : LOAD * LANES]
    while t < end:
        if given.size > 0:
            # a neighbour that is sampled later than the motion that chose them goes on with the last one
            stop = given[count] if count < given.size else t + h
            h = stop - t
        else:
            limit = drive[END] if t < drive[END] else end
            stop = limit if t + h > limit or limit - (t + h) < LAST_STEP * h else t + h
        length = stop - t
        if implicit:
            implicit_step(t, length, now, drive, table, lanes)
        else:
            _attempt(t, length, now, drive, k, lanes)
        if given.size == 0:
            if implicit:
                error = _relative(t, table[ORDER], scale, until_s)
            else:
                error = _error(t, length, k, scale, until_s)
            if not error <= 1.0:
                h = length * (SHRINK if not error < FAILED else max(SHRINK, SAFETY * error**power))
                if h < SHORTEST_S:
                    break
                continue
            grow = GROW if error == 0.0 else min(GROW, SAFETY * error**power)
            h = max(h, length * grow) if length < h else length * grow
        if implicit:
            rates(stop, drive, lanes)
        _sample_step(t, stop, now, k, lanes, first_s, step_s, sampled, implicit, out)
        if count > MOST_STEPS_PER_S * (t + SETTLING_S):
            break
        if count == ends.size:
            more = np.empty(2 * count)
            more[:count] = ends
            ends = more
        ends[count] = stop
        count += 1
        t = stop
        now[:] = lanes[:STATE_SIZE]
        if given.size == 0 and _lost(t, now, until_s):
            break
        if implicit:
            k[0] = lanes[RATE * LANES : LOAD * LANES]
        elif stop == drive[END]:
            rates(t, drive, lanes)
            k[0] = lanes[RATE * LANES : LOAD * LANES]
        else:
            k[0] = k[STAGES - 1]
    return ends[:count]


def padded(items: Sequence[T]) -> list[T]:
    """As many as there are lanes, of which the last one is repeated."""
    return [*items, *[items[-1]] * (LANES - len(items))]
