"""An independent reference for the rotor's motion: scipy's DOP853 with terminal events at the turning points."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, sin

import numpy as np
from scipy.integrate import solve_ivp

Field = Callable[[float], tuple[float, float]]


def no_field(_t: float) -> tuple[float, float]:
    return 0.0, 0.0


def swing(t_end, phi, v, *, lam, w, tf=0.0, m_i=0.0, b=no_field, times=None, rtol=3e-14, t_start=0.0):
    """Angle and speed at `times` and the final state; sticks exactly where |torque| <= friction at rest."""
    driven = b is not no_field

    def smooth(t, p, s):
        total = -2 * lam * s - w * w * sin(p)
        if driven:
            b_u, b_v = b(t)
            total += m_i * (b_v * cos(p) - b_u * sin(p))
        return total

    def dry(p):
        return tf * max(cos(p), 0.0) ** (4 / 3)

    times = np.zeros(0) if times is None else times
    out = np.zeros((2, times.size))
    t, done = t_start, 0
    while t < t_end:
        if tf > 0 and v == 0.0:
            push = smooth(t, p=phi, s=0.0)
            if abs(push) <= dry(phi):
                if not driven:
                    break
                grid = np.linspace(t, t_end, 20001)[1:]
                loose = [g for g in grid if abs(smooth(g, phi, 0.0)) > dry(phi)]
                if not loose:
                    break
                low, high = loose[0] - (t_end - t) / 20000, loose[0]
                for _ in range(60):
                    mid = 0.5 * (low + high)
                    low, high = (low, mid) if abs(smooth(mid, phi, 0.0)) > dry(phi) else (mid, high)
                t = high
                push = smooth(t, phi, 0.0)
            sign = np.sign(push)
        else:
            sign = np.sign(v)

        def rhs(t, y, sign=sign):
            return (y[1], smooth(t, y[0], y[1]) - sign * dry(y[0]))

        def turn(t, y, sign=sign, t_0=t):
            return sign * y[1] if t > t_0 + 1e-9 else 1.0

        turn.terminal = True
        r = solve_ivp(rhs, (t, t_end), (phi, v), "DOP853", rtol=rtol, atol=rtol * np.array([1e-3, 1.0]),
                      events=turn if tf > 0 else None, dense_output=times.size > 0)  # fmt: skip
        t, (phi, v) = r.t[-1], r.y[:, -1]
        if r.status == 1:
            v = 0.0
        upto = np.searchsorted(times, t, side="right")
        if upto > done:
            out[:, done:upto] = r.sol(times[done:upto])
            done = upto
    out[0, done:] = phi
    return out[0], out[1], phi, v


def follow(rhs, y, times, *, turns=False, hold=None, rtol=3e-14, method="DOP853"):
    """States (n, len(y)) at rising `times` of y' = rhs(t, y, sign), y = (phi, phi', ...), integrated to each of them.

    turns: cut where phi' changes sign; sign: of phi' in between; hold(y): largest push that leaves the rotor at rest.
    """
    t, y = 0.0, np.array(y, dtype=float)
    sign, out = np.sign(y[1]), []
    for end in times:
        while t < end:
            if turns and y[1] == 0.0:
                push = rhs(t, y, 0.0)[1]
                sign = np.sign(push)
                if hold is not None and abs(push) <= hold(y):
                    break

            def turn(t, y, sign=sign, t_0=t):
                return sign * y[1] if t > t_0 + 1e-9 else 1.0

            turn.terminal = True
            scale = rtol * np.array([1e-3, 1.0, *(1e-3 for _ in y[2:])])
            r = solve_ivp(lambda t, y, sign=sign: rhs(t, y, sign), (t, end), y, method, rtol=rtol, atol=scale,
                          events=turn if turns else None)  # fmt: skip
            t, y = float(r.t[-1]), r.y[:, -1].copy()
            if r.status == 1:
                y[1] = 0.0
        t = end
        out.append(y.copy())
    return np.array(out)
