"""pyoperon: symbolic regression of the acceleration that the declared frequency does not explain."""

from __future__ import annotations

import importlib
import itertools
import math
from typing import Any

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from tests.benchmarks.peers.columns import Model, scaled
from tests.benchmarks.peers.datasets import Task
from tests.benchmarks.peers.sindy import columns, physical, scaled_states
from tests.benchmarks.peers.viscous import fit_declared

LENGTH, SEED, POINTS = 25, 1, 4000
SETTINGS = (
    f"SymbolicRegressor(allowed_symbols='add,sub,mul,div,constant,variable,abs,tanh', max_length={LENGTH}, "
    f"random_state={SEED}, n_threads=1, else as it comes) on {POINTS} samples of "
    "(phi'' + w^2 sin phi)/w^2 against phi and phi'/w, w from the floor; named: the fewest of the physical columns, "
    "three at most, that make up 99 % of the formula's variance along the training part; ends at the time box"
)
_SHARE = 0.99


def residual_formula(task: Task, box_s: float) -> tuple[Model, str]:
    """The sine of the floor and a formula for the rest; its terms are those of the best few columns."""
    floor = fit_declared(task)
    w = math.sqrt(floor.terms["sine"])
    data = scaled_states(task, w)
    x = np.concatenate([np.stack([p, v], axis=1) for _, p, v, _ in data])
    y = np.concatenate([a + np.sin(p) for _, p, _, a in data])
    chosen = np.random.default_rng(SEED).choice(len(y), min(POINTS, len(y)), replace=False)
    operon: Any = importlib.import_module("pyoperon.sklearn")
    fit = operon.SymbolicRegressor(
        allowed_symbols="add,sub,mul,div,constant,variable,abs,tanh", max_length=LENGTH, random_state=SEED,
        max_time=round(box_s), n_threads=1, generations=10**6, max_evaluations=10**9,
    )  # fmt: skip
    fit.fit(x[chosen], y[chosen])
    formula = str(fit.get_model_string(fit.model_, 8))
    code = compile(formula.strip(), "formula", "eval")
    known = {"tanh": math.tanh, "abs": abs}

    def torque(phi: float, v: float, t: float) -> float:
        try:
            more = float(eval(code, known, {"X1": phi, "X2": v / w}))
        except (ZeroDivisionError, OverflowError):
            more = 0.0
        return w * w * (more - math.sin(phi))

    made = np.array([torque(float(p), float(v) * w, 0.0) / w**2 + math.sin(p) for p, v in x[chosen]])
    terms = scaled([("sine", 1.0), *_read(x[chosen], made, task)], w)
    return Model(torque, terms, floor.speed), formula


def _read(x: Array, made: Array, task: Task) -> list[tuple[str, float]]:
    """Which columns a formula consists of."""
    names = [n for n in physical(task) if n != "sine"]
    theta = columns(x[:, 0], x[:, 1], names)
    best: tuple[float, list[tuple[str, float]]] = (-math.inf, [])
    for count in (1, 2, 3):
        for picked in itertools.combinations(range(len(names)), count):
            c, *_ = np.linalg.lstsq(theta[:, picked], made, rcond=None)
            share = 1.0 - float(np.mean((made - theta[:, picked] @ c) ** 2) / max(float(np.mean(made**2)), 1e-300))
            if share > best[0]:
                best = share, [(names[k], float(q)) for k, q in zip(picked, c, strict=True)]
        if best[0] > _SHARE:
            break
    return best[1]
