"""The motion by scipy.integrate.solve_ivp, from turning point to turning point where friction is dry."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from tests.campaigns.angle_study.motion import (
    PLACE,
    Array,
    Motion,
    acceleration,
    beside,
    direction_from_rest,
    holds,
    vector,
)

_RTOL, _ATOL = 1e-11, 1e-13
_KINKS = ("coulomb", "quadratic")


def _turning(_: float, y: Array, *__: object) -> float:
    return float(y[1])


_turning.terminal = True  # type: ignore[attr-defined]


def true_reading(times: Array, motion: Motion) -> tuple[Array, float]:
    """(what an ideal encoder shows at these times, from when on the motion rests, s; inf: it does not).

    times: rise from 0.
    """
    p = vector(motion)
    kick_s = p[PLACE["kick_s"]] if p[PLACE["kick"]] else math.inf
    out, rests_s = np.empty(times.size), math.inf
    t, phi, v = 0.0, p[PLACE["phi"]], p[PLACE["v"]]
    turns: Callable[..., float] = _turning
    kinks = any(p[PLACE[name]] for name in _KINKS)
    sigma = math.copysign(1.0, v) if v else direction_from_rest(t, phi, p)
    while t < times[-1]:
        until = kick_s if t < kick_s else times[-1] + 1e-9
        _turning.direction = -sigma  # type: ignore[attr-defined]
        until = min(until, times[-1] + 1e-9)
        leg = solve_ivp(
            lambda x, y, s=sigma: (y[1], acceleration(x, y[0], y[1], s if kinks else math.copysign(1.0, y[1]), p)),
            (t, until), (phi, v), method="DOP853", rtol=_RTOL, atol=_ATOL, dense_output=True,
            events=turns if kinks else None,
        )  # fmt: skip
        inside = slice(*np.searchsorted(times, (t, leg.t[-1])))
        if leg.sol is not None and inside.stop > inside.start:
            out[inside] = leg.sol(times[inside])[0]
        t, (phi, v) = float(leg.t[-1]), leg.y[:, -1]
        if t == kick_s:
            v, kick_s = v + p[PLACE["kick"]], math.inf
            sigma = math.copysign(1.0, v)
        elif leg.status == 1:
            v = 0.0
            if holds(t, phi, p):
                out[times >= t], rests_s = phi, t
                break
            sigma = direction_from_rest(t, phi, p)
    return out + beside(times, p), rests_s
