"""The velocity-weighted weak form: an energy balance over bumps of three periods, free of phi''.

phi'' = sum c_k f_k(phi, phi') is multiplied by b(t) phi' and integrated: the left side becomes -int b' phi'^2/2, the
losses become their work, and torques of phi alone int b' U(phi). Torques of phi alone are told from the same with the
weight b(t) phi, whose left side is -int b phi'^2 + int b'' phi^2/2.
"""

from __future__ import annotations

import math

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from tests.benchmarks.peers.columns import COLUMNS, LIBRARY, Model, model_of, scaled
from tests.benchmarks.peers.datasets import Task
from tests.benchmarks.peers.sindy import overview, physical, scaled_states, sparse

PERIODS, STEP, THRESHOLD = 3.0, 0.25, 0.05
CONSERVATIVE = ("sine", "cubic_restoring", "bias_torque")
SETTINGS = (
    f"bumps (1 - x^2)^4 of {PERIODS:g} periods, one every {STEP:g} period; the physical columns: torques of phi by the "
    "weight b phi, then losses by the weight b phi'; "
    f"STLSQ(threshold={THRESHOLD:g} of the left side's rms, alpha=1e-6) on columns of unit rms"
)


def energy_balance(task: Task) -> Model:
    """Both steps."""
    w, speed = overview(task)
    both = [rows(*s) for s in scaled_states(task, w)]
    by_phi, by_v = (
        tuple(np.concatenate(parts) for parts in zip(*kind, strict=True)) for kind in zip(*both, strict=True)
    )
    held = _solve(by_phi[0], by_phi[1], CONSERVATIVE)
    conservative = [LIBRARY.index(n) for n in CONSERVATIVE]
    work = by_v[1] - by_v[0][:, conservative] @ held
    losses = tuple(n for n in physical(task) if n not in CONSERVATIVE)
    found = _solve(by_v[0], work, losses)
    terms = [*zip(CONSERVATIVE, map(float, held), strict=True), *zip(losses, map(float, found), strict=True)]
    return model_of(scaled(terms, w), speed)


def _solve(theta: Array, target: Array, names: tuple[str, ...]) -> Array:
    picked = theta[:, [LIBRARY.index(n) for n in names]]
    return np.array(sparse(picked, target, THRESHOLD * float(np.sqrt(np.mean(target**2)))))


def rows(time: Array, phi: Array, v: Array, _: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Columns and left sides by the two weights, one row per bump; time in units of 1/w."""
    dt = float(time[1] - time[0])
    half = int(0.5 * PERIODS * 2.0 * math.pi / dt)
    x = np.arange(-half, half + 1) / half
    width = half * dt
    b = (1.0 - x**2) ** 4
    b1 = -8.0 * x * (1.0 - x**2) ** 3 / width
    b2 = (-8.0 * (1.0 - x**2) ** 3 + 48.0 * x**2 * (1.0 - x**2) ** 2) / width**2
    starts = np.arange(0, phi.size - x.size, max(1, int(STEP * 2.0 * math.pi / dt)))
    torques = np.stack([COLUMNS[n].array(phi, v) for n in LIBRARY], axis=1)
    potential = {"sine": -np.cos(phi), "cubic_restoring": -0.25 * phi**4, "bias_torque": -phi}
    columns_phi: list[Array] = []
    columns_v: list[Array] = []
    left_phi: list[float] = []
    left_v: list[float] = []
    for k in starts:
        p, q, f = phi[k : k + x.size], v[k : k + x.size], torques[k : k + x.size]
        columns_phi.append((b * p) @ f * dt)
        left_phi.append(float(-b @ q**2 + 0.5 * b2 @ p**2) * dt)
        row = (b * q) @ f * dt
        for name, u in potential.items():
            row[LIBRARY.index(name)] = b1 @ u[k : k + x.size] * dt
        columns_v.append(row)
        left_v.append(float(-0.5 * b1 @ q**2) * dt)
    return (np.array(columns_phi), np.array(left_phi)), (np.array(columns_v), np.array(left_v))
