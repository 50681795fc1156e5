"""PySINDy 2.1 on derivatives: as shipped, and on columns of unit rms."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from tests.benchmarks.peers.columns import COLUMNS, LIBRARY, Model, model_of, scaled
from tests.benchmarks.peers.datasets import Task
from tests.benchmarks.peers.states import States, states_of

SHIPPED = (
    "SINDy(STLSQ() as it comes: threshold 0.1, alpha 0.05), the ten columns, on phi, phi' and phi'' by "
    "Savitzky-Golay; angles in s, dm/dt in units of 1/w (raw, every coefficient would pass the threshold)"
)
THRESHOLD = 1e-3  # of w^2
PHYSICAL = (
    "sine", "cubic_restoring", "viscous_damping", "quadratic_drag", "coulomb_friction", "bias_torque",
    "angle_dependent_damping",
)  # fmt: skip
UNIT_RMS = (
    f"the ten columns, STLSQ(threshold={THRESHOLD:g}, alpha=1e-6) in units of 1/w, every column divided by its rms"
)
UNIT_RMS_PHYSICAL = f"the same on {', '.join(PHYSICAL)}, and what is declared"
_POINTS = 20000


def physical(task: Task) -> tuple[str, ...]:
    """Columns that somebody would choose who knows what a pendulum can have."""
    return tuple(dict.fromkeys((*PHYSICAL, *task.declared)))


def scaled_states(task: Task, w: float) -> list[tuple[Array, Array, Array, Array]]:
    """Time, phi, phi' and phi'' of every training record in units of 1/w, thinned out."""
    found = []
    for record in task.train:
        s = states_of(record)
        thin = slice(None, None, max(1, s.phi.size * len(task.train) // _POINTS))
        found.append((s.time_s[thin] * w, s.phi[thin], s.v[thin] / w, s.a[thin] / w**2))
    return found


def columns(phi: Array, v: Array, names: Sequence[str] = LIBRARY) -> Array:
    """(n, columns)."""
    return np.stack([COLUMNS[n].array(phi, v) for n in names], axis=1)


def overview(task: Task) -> tuple[float, float]:
    """Angular frequency and largest speed of the training part."""
    found: list[States] = [states_of(r) for r in task.train]
    return float(np.mean([s.w for s in found])), float(max(np.abs(s.v).max() for s in found))


def as_shipped(task: Task) -> Model:
    """The whole of SINDy, as its first example uses it."""
    ps: Any = importlib.import_module("pysindy")
    w, speed = overview(task)
    unit = 1.0 if task.scored.quantity == "angle" else w
    data = scaled_states(task, unit)
    library = ps.CustomLibrary(
        library_functions=[COLUMNS[n].array for n in LIBRARY], function_names=[_name(n) for n in LIBRARY]
    )
    x = [np.stack([p, v], axis=1) for _, p, v, _ in data]
    x_dot = [np.stack([v, a], axis=1) for _, _, v, a in data]
    sindy = ps.SINDy(optimizer=ps.STLSQ(), feature_library=library)
    sindy.fit(x, t=[t for t, *_ in data], x_dot=x_dot)
    assert tuple(sindy.get_feature_names()) == LIBRARY
    row = [float(c) for c in sindy.coefficients()[1]]
    return model_of(scaled(list(zip(LIBRARY, row, strict=True)), unit), speed)


def _name(name: str) -> Callable[[str, str], str]:
    return lambda phi, v: name


def unit_rms(task: Task, names: Sequence[str] = LIBRARY) -> Model:
    """Its optimiser on columns that are alike in size."""
    w, speed = overview(task)
    data = scaled_states(task, w)
    theta = np.concatenate([columns(p, v, names) for _, p, v, _ in data])
    found = sparse(theta, np.concatenate([a for *_, a in data]), THRESHOLD)
    return model_of(scaled(list(zip(names, found, strict=True)), w), speed)


def unit_rms_physical(task: Task) -> Model:
    """The same, told which columns make sense."""
    return unit_rms(task, physical(task))


def sparse(theta: Array, target: Array, threshold: float) -> list[float]:
    """Coefficients by STLSQ on columns of unit rms, threshold in units of the target."""
    ps: Any = importlib.import_module("pysindy")
    size = np.sqrt(np.mean(theta**2, axis=0))
    fit = ps.STLSQ(threshold=threshold, alpha=1e-6).fit(theta / size, target[:, None])
    return [float(c) for c in np.ravel(fit.coef_) / size]
