"""An independent source of ring-downs: classical Runge-Kutta on a fine grid, turning points by bisection.

Shares no line with the estimator. Everything in physical units (rad, s).
"""

import math
from dataclasses import dataclass, replace

import numba
import numpy as np

RATE_HZ = 125e6 / 2048
NOISE_SD = np.array([0.014, 0.021, 0.055])


@numba.njit(cache=True)
def _acceleration(phi, rate, sign, w, lam, tf):
    friction = 0.0
    if tf != 0.0 and math.cos(phi) > 0.0:
        friction = sign * tf * math.cos(phi) ** (4.0 / 3.0)
    return -2.0 * lam * rate - w * w * math.sin(phi) - friction


@numba.njit(cache=True)
def _rk4(phi, rate, low, h, sign, w, lam, tf, m, pole):
    """One step; `low` is a one-pole low-pass of the two dipole rates (pole in s, 0: none)."""
    p, r, a, b = phi, rate, low[0], low[1]
    dp = dr = da = db = 0.0
    kp = kr = ka = kb = 0.0
    for stage in range(4):
        if stage > 0:
            f = 1.0 if stage == 3 else 0.5
            p, r, a, b = phi + f * h * kp, rate + f * h * kr, low[0] + f * h * ka, low[1] + f * h * kb
        kp = r
        kr = _acceleration(p, r, sign, w, lam, tf)
        if pole > 0.0:
            ka = (m * r * math.cos(p) - a) / pole
            kb = (-m * r * math.sin(p) - b) / pole
        g = 1.0 / 6.0 if stage in (0, 3) else 1.0 / 3.0
        dp += g * kp
        dr += g * kr
        da += g * ka
        db += g * kb
    return phi + h * dp, rate + h * dr, low[0] + h * da, low[1] + h * db


@numba.njit(cache=True)
def _simulate(phi, rate, w, lam, tf, m, pole, dt, substeps, skip, n):
    """(2, n): v and u components of dm/dt at t = (skip + i) dt; (n,) angle."""
    out = np.zeros((2, n))
    angle = np.zeros(n)
    low = np.array([m * rate * math.cos(phi), -m * rate * math.sin(phi)])
    stuck = False
    sign = 1.0 if rate > 0.0 else -1.0
    if rate == 0.0:
        sign = -1.0 if phi > 0.0 else 1.0
    h = dt / substeps
    for i in range(skip + n):
        if i >= skip:
            angle[i - skip] = phi
            if pole > 0.0:
                out[0, i - skip], out[1, i - skip] = low[0], low[1]
            else:
                out[0, i - skip] = m * rate * math.cos(phi)
                out[1, i - skip] = -m * rate * math.sin(phi)
        for _ in range(substeps):
            left = h
            while left > 0.0:
                if stuck:
                    if pole > 0.0:
                        low *= math.exp(-left / pole)
                    break
                p, r, a, b = _rk4(phi, rate, low, left, sign, w, lam, tf, m, pole)
                if r * sign >= 0.0:
                    phi, rate, low[0], low[1] = p, r, a, b
                    break
                before, after = 0.0, left
                for _ in range(60):
                    middle = 0.5 * (before + after)
                    p, r, a, b = _rk4(phi, rate, low, middle, sign, w, lam, tf, m, pole)
                    if r * sign >= 0.0:
                        before = middle
                    else:
                        after = middle
                phi, rate, low[0], low[1] = p, 0.0, a, b
                left -= after
                sign = -sign
                pull = _acceleration(phi, 0.0, sign, w, lam, tf)
                if pull * sign <= 0.0:
                    stuck = True
    return out, angle


@dataclass(frozen=True)
class Truth:
    """Physical truth of one shot, in the published parametrisation."""

    f_nat_hz: float = 215.5
    m_r_am2: float = 0.01165
    lambda_per_s: float = 0.2465
    tf_over_i_rad_per_s2: float = 0.0
    phi_max_rad: float = 0.39
    psi_start_rad: float = 5.84
    rodrigues: tuple = (0.0625, -0.0156, -1.53)

    def value(self, name):
        if name.startswith("rodrigues"):
            return self.rodrigues["xyz".index(name[-1])]
        return getattr(self, name)

    def with_(self, **changes):
        return replace(self, **changes)


def rotation(rodrigues):
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(rodrigues).as_matrix()


def dmdt(truth, seconds, rate_hz=RATE_HZ, pole_s=0.0, lead_s=0.0, substeps=None):
    """(3, n) dm/dt in world axes at t = i / rate; `lead_s`: start that much earlier to settle a low-pass."""
    w = 2 * math.pi * truth.f_nat_hz
    phi = truth.phi_max_rad * math.cos(truth.psi_start_rad)
    rate = -w * math.sqrt(2 - 2 * math.cos(truth.phi_max_rad)) * math.sin(truth.psi_start_rad)
    n = round(seconds * rate_hz)
    if substeps is None:
        substeps = max(1, math.ceil(900 * truth.f_nat_hz / rate_hz))
    skip = round(lead_s * rate_hz)
    local, _ = _simulate(
        phi, rate, w, truth.lambda_per_s, truth.tf_over_i_rad_per_s2, truth.m_r_am2, pole_s, 1 / rate_hz,
        substeps, skip, n,
    )  # fmt: skip
    r = rotation(truth.rodrigues)
    return r[:, [1]] * local[0] + r[:, [0]] * local[1]


def with_noise(signal, rng, sd=NOISE_SD):
    return signal + rng.standard_normal(signal.shape) * np.asarray(sd)[:, None]


def random_truth(rng, variant, f_range=(120.0, 350.0), deg_range=(8.0, 70.0)):
    """Any orientation obeying e_v . x > 0, any phase."""
    from scipy.spatial.transform import Rotation

    matrix = Rotation.random(random_state=rng).as_matrix()
    if matrix[0, 1] < 0:
        matrix = matrix @ np.diag([1.0, -1.0, -1.0])
    f = rng.uniform(*f_range)
    w = 2 * math.pi * f
    phi = math.radians(rng.uniform(*deg_range))
    jewel = variant == "jewel"
    return Truth(
        f_nat_hz=f,
        m_r_am2=rng.uniform(0.008, 0.015),
        lambda_per_s=w / 2 / rng.uniform(800, 3000),
        tf_over_i_rad_per_s2=w * w * rng.uniform(3e-4, 9e-4) if jewel else 0.0,
        phi_max_rad=phi,
        psi_start_rad=rng.uniform(0, 2 * math.pi),
        rodrigues=tuple(Rotation.from_matrix(matrix).as_rotvec()),
    )


def errors(result, truth):
    """(k,) estimate minus truth in the order of the covariance, angles and Rodrigues vectors unwrapped."""
    names = result.covariance_names
    miss = np.array([result.parameters[n].value - truth.value(n) for n in names])
    for k, n in enumerate(names):
        if n == "psi_start_rad":
            miss[k] = (miss[k] + math.pi) % (2 * math.pi) - math.pi
    where = [k for k, n in enumerate(names) if n.startswith("rodrigues")]
    if where:
        estimate = np.array([result.parameters[f"rodrigues_{a}"].value for a in "xyz"])
        true = np.array(truth.rodrigues)
        length = np.linalg.norm(true)
        # The same rotation, the other way round: continuous across length pi.
        other = true * (1 - 2 * math.pi / length) if length > 0 else true
        if np.linalg.norm(estimate - other) < np.linalg.norm(estimate - true):
            true = other
        miss[where] = estimate - true
    return miss


def joint_chi2(result, truth):
    miss = errors(result, truth)
    return float(miss @ np.linalg.solve(result.covariance, miss))
