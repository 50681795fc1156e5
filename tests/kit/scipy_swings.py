"""Swings of a thread with a further loss by scipy's DOP853, which share no line with the estimator."""

import math

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation


def thread_dm_dt(truth, seconds, rate_hz, *, dry=0.0, drag=0.0):
    """(3, n) A m^2/s from rest at phi_max on; dry: Coulomb friction per inertia, rad/s^2; drag: -b phi'|phi'|, 1/rad.

    truth: public parameters, with psi_start 0.
    """
    w, damping = 2.0 * math.pi * truth["f_nat_hz"], truth["lambda_per_s"]
    times = np.arange(round(seconds * rate_hz)) / rate_hz
    angle, speed = np.empty_like(times), np.empty_like(times)
    at, state, sign = 0.0, np.array([truth["phi_max_rad"], 0.0]), -1.0

    def rate(t, y, sign):
        return [y[1], -w * w * math.sin(y[0]) - 2.0 * damping * y[1] - sign * (dry + drag * y[1] ** 2)]

    def turning(t, y, sign):
        return y[1] if t > at + 0.25 / truth["f_nat_hz"] else sign

    turning.terminal = True
    while at < times[-1]:
        end = min(times[-1] + 1.0 / rate_hz, at + 1.0 / truth["f_nat_hz"])
        done = solve_ivp(
            rate, (at, end), state, "DOP853", args=(sign,), events=turning, dense_output=True, rtol=1e-11, atol=1e-13
        )
        inside = (times >= at) & (times <= done.t[-1])
        angle[inside], speed[inside] = done.sol(times[inside])
        at, state, sign = float(done.t[-1]), np.array([done.y[0, -1], 0.0]), -sign
    m_r = truth["m_r_am2"]
    local = np.stack([-m_r * speed * np.sin(angle), m_r * speed * np.cos(angle), np.zeros(times.size)])
    return Rotation.from_rotvec([truth[f"rodrigues_{axis}"] for axis in "xyz"]).as_matrix() @ local
