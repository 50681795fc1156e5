"""Other people's solvers on the record of `make bench` beside the fit: diffrax and CasADi, where `make peers` put them.

The fit of TN50 (three channels of dm/dt, thread, 0.24 s) written as anybody would with them: start state, frequency,
damping, moment and orientation, 8 numbers; Gauss-Newton with their own forward derivatives to a relative step of 1e-8.
Both begin at the same start near the truth, 1e-4 beside it in frequency and 1 % in everything else; our fit cannot be
told a start and finds its own within its time. What is compiled is compiled before the clock starts, and its time is
told apart.
"""

from __future__ import annotations

import importlib
import math
import time
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from tests.benchmarks.fits import DATASETS, RATE_HZ, make_record

Jacobian = Callable[[Array], tuple[Array, Array]]
"""Residual (3 n,) and its derivatives (3 n, 8) at the scaled parameters."""
_RODRIGUES = (0.0625, -0.0156, -1.53)
_STEPS = 30


def near_truth() -> tuple[Array, Array]:
    """Scale of the parameters phi, phi', w, lambda, m_r and R, and the start in units of it."""
    d = DATASETS[2]
    phi = d.dynamics.amplitude * math.cos(d.dynamics.theta)
    v = -d.dynamics.amplitude * d.dynamics.w * math.sin(d.dynamics.theta)
    scale = np.array([phi, v, d.dynamics.w, d.dynamics.values[0], d.m_r_am2, *_RODRIGUES])
    return scale, np.array([1.01, 0.99, 1.0001, 1.01, 0.99, 1.01, 0.99, 1.01])


def gauss_newton(jacobian: Jacobian, x: Array) -> tuple[Array, int]:
    """Parameters, and how often the derivatives were computed."""
    for k in range(1, _STEPS + 1):
        r, j = jacobian(x)
        step = np.linalg.solve(j.T @ j, -j.T @ r)
        x = x + step
        if np.abs(step).max() < 1e-8:
            return x, k
    return x, _STEPS


def with_diffrax(samples: Array) -> Jacobian:
    """Dopri8 at 1e-9 with saved samples, forward mode."""
    jax: Any = importlib.import_module("jax")
    diffrax: Any = importlib.import_module("diffrax")
    jax.config.update("jax_enable_x64", True)
    jnp = jax.numpy
    scale = jnp.asarray(near_truth()[0])
    at, measured = jnp.arange(samples.shape[1]) / RATE_HZ, jnp.asarray(samples)

    def rates(t: Any, y: Any, p: Any) -> Any:
        return jnp.stack([y[1], -(p[0] ** 2) * jnp.sin(y[0]) - 2.0 * p[1] * y[1]])

    def residual(x: Any) -> Any:
        p = x * scale
        found = diffrax.diffeqsolve(
            diffrax.ODETerm(rates), diffrax.Dopri8(), 0.0, at[-1], 1e-4, p[:2], p[2:4], max_steps=20000,
            saveat=diffrax.SaveAt(ts=at), adjoint=diffrax.ForwardMode(),
            stepsize_controller=diffrax.PIDController(rtol=1e-9, atol=jnp.array([1e-9, 1e-6])),
        )  # fmt: skip
        phi, v = found.ys[:, 0], found.ys[:, 1]
        local = jnp.stack([-jnp.sin(phi) * v, jnp.cos(phi) * v])
        return (p[4] * _rotation(jnp, p[5:8])[:, :2] @ local - measured).ravel()

    both = jax.jit(lambda x: (residual(x), jax.jacfwd(residual)(x)))

    def jacobian(x: Array) -> tuple[Array, Array]:
        r, j = both(x)
        return np.asarray(r), np.asarray(j)

    return jacobian


def with_casadi(samples: Array) -> Jacobian:
    """RK4 from sample to sample by mapaccum, forward derivatives by the chain through it."""
    ca: Any = importlib.import_module("casadi")
    scale, n = near_truth()[0], samples.shape[1]
    y, p, h = ca.SX.sym("y", 2), ca.SX.sym("p", 2), 1.0 / RATE_HZ
    rates = ca.Function("rates", [y, p], [ca.vertcat(y[1], -(p[0] ** 2) * ca.sin(y[0]) - 2.0 * p[1] * y[1])])
    one = rates(y, p)
    two = rates(y + 0.5 * h * one, p)
    three = rates(y + 0.5 * h * two, p)
    step = ca.Function("step", [y, p], [y + h / 6.0 * (one + 2.0 * two + 2.0 * three + rates(y + h * three, p))])
    # The state with its derivatives by phi, phi', w, lambda is carried from sample to sample.
    carried = ca.SX.sym("s", 2, 4)
    by_y, by_p = (ca.jacobian(step(y, p), q) for q in (y, p))
    own = ca.horzcat(ca.SX.zeros(2, 2), by_p)
    whole = ca.vertcat(step(y, p), ca.vec(by_y @ carried + own))
    run = ca.Function("whole", [ca.vertcat(y, ca.vec(carried)), p], [whole]).mapaccum("run", n - 1)

    def jacobian(x: Array) -> tuple[Array, Array]:
        q = x * scale
        first = np.concatenate([q[:2], np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]]).T.ravel()])
        path = np.concatenate([first[:, None], run(first, np.tile(q[2:4, None], n - 1)).full()], axis=1)
        phi, v, slopes = path[0], path[1], path[2:].reshape(4, 2, n)
        local = np.stack([-np.sin(phi) * v, np.cos(phi) * v])
        by_state = np.stack([np.stack([-np.cos(phi) * v, -np.sin(phi) * v]), np.stack([-np.sin(phi), np.cos(phi)])])
        gains = q[4] * np.asarray(_rotation(np, q[5:8]))[:, :2]
        columns = [gains @ np.einsum("scn,sn->cn", by_state, s) for s in slopes]
        columns.append(gains @ local / q[4])
        for k in range(3):
            moved = q[5:8] + 1e-6 * np.eye(3)[k]
            columns.append(q[4] * (np.asarray(_rotation(np, moved))[:, :2] - gains / q[4]) @ local / 1e-6)
        return (gains @ local - samples).ravel(), np.stack([c.ravel() for c in columns], axis=1) * scale

    return jacobian


def _rotation(xp: Any, rodrigues: Any) -> Any:
    """exp of the cross product with it, (3, 3)."""
    angle = xp.sqrt(xp.sum(rodrigues**2))
    x, y, z = rodrigues / angle
    cross = xp.array([[0.0 * x, -z, y], [z, 0.0 * x, -x], [-y, x, 0.0 * x]])
    return xp.eye(3) + xp.sin(angle) * cross + (1.0 - xp.cos(angle)) * cross @ cross


SOLVERS: dict[str, Callable[[Array], Jacobian]] = {"diffrax": with_diffrax, "casadi": with_casadi}


def run_solvers(repeats: int = 5) -> dict[str, Any]:
    """{name: {"compile_s", "fit_ms", "steps", "worst"}} of those that are installed; worst: largest relative error."""
    samples, (_, start), found = make_record(DATASETS[2]).samples, near_truth(), {}
    for name, make in SOLVERS.items():
        if find_spec(name) is None:
            continue
        began = time.process_time()
        jacobian = make(samples)
        jacobian(start)
        compiled = time.process_time() - began
        times = []
        for _ in range(repeats):
            began = time.process_time()
            x, steps = gauss_newton(jacobian, start)
            times.append(time.process_time() - began)
        worst = float(np.abs(x - 1.0).max())
        found[name] = {"compile_s": compiled, "fit_ms": 1e3 * float(np.median(times)), "steps": steps, "worst": worst}
    return found


def solvers_text(found: dict[str, Any], ours_ms: float) -> str:
    """One line per solver."""
    lines = [
        f"TN50 by {n}: {r['fit_ms']:.0f} ms in {r['steps']} steps, compiled in {r['compile_s']:.1f} s; "
        f"{r['fit_ms'] / ours_ms:.0f} times our fit, which finds its start itself"
        for n, r in found.items()
    ]
    return "\n".join(lines) or "diffrax and CasADi are not installed: `make peers` installs them"
