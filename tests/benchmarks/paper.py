"""The paper's fit rebuilt with scipy, for comparison only: finite differences, tanh in place of sgn, a stiff solver.

It is started at the truth, which the paper's was not, and stopped when its time is up.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.rotation import rotation_from_rodrigues
from platform_daemon.estimation.physics.trajectory.direct import MotionParameters

_SMOOTHING = 0.1  # s/rad: tanh(k phi') in place of sgn(phi')
_TOLERANCE = 1e-8


class _TimeUpError(Exception):
    """The time box is spent."""


@dataclass(frozen=True)
class PaperFit:
    """Processor time of this thread in s, and whether it converged within its time."""

    seconds: float
    finished: bool


def paper_method(
    samples: Array, rate_hz: float, truth: MotionParameters, m_r_am2: float, rodrigues: Array, limit_s: float
) -> PaperFit:
    """Levenberg-Marquardt with numerical derivatives on dm/dt samples (3, n); friction only if the truth has any."""
    began = time.thread_time()
    time_s = np.arange(samples.shape[1]) / rate_hz
    deadline = began + limit_s
    # Scaled so that every parameter is about 1: w, amplitude, phase, m_r, R, losses.
    scale = np.array([truth.w, truth.amplitude, 1.0, m_r_am2, 1.0, 1.0, 1.0, *truth.values])
    start = np.array([1.0, 1.0, truth.theta, 1.0, *rodrigues, *np.ones(len(truth.values))])

    def residual(x: Array) -> Array:
        p = x * scale
        if time.thread_time() > deadline:
            raise _TimeUpError
        phi, rate = _motion(p, time_s, deadline)
        local = np.stack([rate * np.cos(phi), -rate * np.sin(phi)])
        model = p[3] * rotation_from_rodrigues(p[4:7])[:, [1, 0]] @ local
        return np.asarray((model - samples).ravel())

    try:
        found = least_squares(residual, start, method="lm", max_nfev=40 * start.size)
        finished = bool(found.success)
    except _TimeUpError:
        finished = False
    return PaperFit(time.thread_time() - began, finished)


def _motion(p: Array, time_s: Array, deadline: float) -> tuple[Array, Array]:
    """Angle and angular velocity at the times, both (n,)."""
    w, amplitude, theta = float(p[0]), float(p[1]), float(p[2])
    viscous = float(p[7])
    friction = float(p[8]) if p.size > 8 else 0.0

    def slope(_: float, y: Array) -> list[float]:
        if time.thread_time() > deadline:
            raise _TimeUpError
        phi, rate = y
        dry = friction * math.tanh(_SMOOTHING * rate) * max(math.cos(phi), 0.0) ** (4.0 / 3.0) if friction else 0.0
        return [rate, -2.0 * viscous * rate - w * w * math.sin(phi) - dry]

    begin = -theta / w
    solver: Any = solve_ivp
    solution = solver(
        slope, (begin, float(time_s[-1])), [amplitude, 0.0], method="LSODA" if friction else "DOP853", t_eval=time_s,
        rtol=_TOLERANCE, atol=[_TOLERANCE, _TOLERANCE * w],
    )  # fmt: skip
    return solution.y[0], solution.y[1]
