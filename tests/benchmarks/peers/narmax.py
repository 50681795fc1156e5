"""sysidentpy: a discrete NAR model of the angle alone, run free."""

from __future__ import annotations

import importlib
import math
import warnings
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from platform_daemon.estimation.numerics.arrays import Array
from tests.benchmarks.peers.datasets import Record, Task
from tests.benchmarks.peers.score import Motion, Score, score_motion, scored_samples
from tests.benchmarks.peers.sindy import overview
from tests.benchmarks.peers.states import states_of

PER_PERIOD, LAGS, DEGREE, CANDIDATES = 30, 5, 3, 15
SETTINGS = (
    f"FROLS(model_type='NAR', ylag={LAGS}, Polynomial(degree={DEGREE}), order by AIC among {CANDIDATES}, LeastSquares) "
    f"on {PER_PERIOD} samples a period of the smoothed angle (of several records the longest); free run from its first "
    f"{LAGS} samples, a spline between its samples"
)


def free_run(task: Task) -> Score:
    """Names nothing: its terms are lags."""
    w, _ = overview(task)
    step_s = 2.0 * math.pi / w / PER_PERIOD
    longest = max(task.train, key=lambda r: float(r.time_s[-1] - r.time_s[0]))
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        fit = _frols()
        taught, zero = _decimated(longest, step_s)[1:]
        fit.fit(X=None, y=(taught - zero)[:, None])
        begin = _decimated(task.scored.first(task.start), step_s)
        steps = int((task.scored.time_s[-1] - begin[0]) / step_s) + 2
        first = (begin[1] - zero)[:LAGS, None]
        run = np.ravel(fit.predict(X=None, y=first, forecast_horizon=steps - LAGS))[:steps]
    if not np.isfinite(run).all() or np.abs(run).max() > 50.0:
        return Score(math.inf, math.inf)
    spline = CubicSpline(begin[0] + step_s * np.arange(run.size), run)
    every = scored_samples(task)
    late = slice(int(np.searchsorted(task.scored.time_s, begin[0])), None, every.step)
    at = task.scored.time_s[late]
    return score_motion(Motion(spline(at), spline(at, 1)), task, late)


def _frols() -> Any:
    structure: Any = importlib.import_module("sysidentpy.model_structure_selection")
    basis: Any = importlib.import_module("sysidentpy.basis_function")
    estimation: Any = importlib.import_module("sysidentpy.parameter_estimation")
    return structure.FROLS(
        model_type="NAR", ylag=LAGS, basis_function=basis.Polynomial(degree=DEGREE), order_selection=True,
        n_info_values=CANDIDATES, estimator=estimation.LeastSquares(),
    )  # fmt: skip


def _decimated(record: Record, step_s: float) -> tuple[float, Array, float]:
    """First time, angles and their mean."""
    s = states_of(record)
    at = np.arange(s.time_s[0], s.time_s[-1], step_s)
    angles = CubicSpline(s.time_s, s.phi)(at)
    return float(at[0]), angles, float(angles.mean()) if record.quantity == "angle" else 0.0
