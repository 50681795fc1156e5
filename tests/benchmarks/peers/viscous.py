"""The floor: the declared model, fitted to the trajectory by scipy's least squares."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares

from platform_daemon.estimation.numerics.arrays import Array
from tests.benchmarks.peers.columns import COLUMNS, Model, model_of
from tests.benchmarks.peers.datasets import Record, Task
from tests.benchmarks.peers.score import STEP, first_state, residual, shares
from tests.benchmarks.peers.states import states_of

SETTINGS = (
    "scipy.optimize.least_squares (trust region, relative steps 1e-5) of frequency, viscous damping (and the jewel's "
    "friction) and each record's start and zero offset, to the first 4 periods, then four times as many, at last all "
    "of the training part"
)
_LOSS = 1e-3  # where the losses begin, in units of w


def fit_true(task: Task) -> Model:
    """With the hidden effect, known: what nobody can be better than."""
    return fit_declared(task, task.truth or ())


class _OutOfTime(Exception):
    """The time box is over."""


def fit_declared(task: Task, further: Sequence[str] = (), box_s: float = math.inf) -> Model:
    """Sine, viscous damping and what else is declared, and further torques; as far as it came in box_s of the clock."""
    records = task.train
    states = [states_of(r) for r in records]
    w, speed = float(np.mean([s.w for s in states])), float(max(np.abs(s.v).max() for s in states))
    names = ("sine", *task.declared, *further)
    starts = np.array([first_state(r) for r in records]) / [1.0, speed]
    begin = [_LOSS] * len(task.declared) + [0.1 * _LOSS] * len(further)
    x = np.concatenate([[1.0], begin, starts.ravel()])
    # Large swings are slow: the sine's own frequency lies above the line.
    x[0] = (1.0 + float(max(np.abs(s.phi).max() for s in states)) ** 2 / 32.0) ** 2

    def model(x: Array) -> Model:
        return model_of({n: float(c) * w ** COLUMNS[n].power for n, c in zip(names, x, strict=False)}, speed)

    until = time.monotonic() + box_s

    def cost(x: Array, share: float) -> Array:
        if time.monotonic() > until:
            raise _OutOfTime
        at, states = model(x), x[len(names) :].reshape(-1, 2) * [1.0, speed]
        pairs: list[tuple[Record, Array]] = list(zip(records, states, strict=True))
        return np.concatenate([residual(r, at, s, int(share * r.time_s.size)) for r, s in pairs])

    with contextlib.suppress(_OutOfTime):
        for share in shares(records[0], w):
            x = least_squares(cost, x, args=(share,), x_scale="jac", diff_step=[STEP] * x.size, max_nfev=200).x
    return model(x)
