"""Damped Gauss-Newton over shots together, in windows that grow.

A window of the whole ring-down has many minima, because the phase of a swing counts hundreds of turns; in a short one
the start values of a single angle are near enough.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.rigid_rotor.rotor import LostRotorError, NoRestError, RotorValues
from platform_daemon.estimation.thresholds import THRESHOLDS

from .parameters import DEFECTS, Defect, FreeParameter, free_parameters
from .shot import RotorShot, chi2_of, linearised

LIMITS = THRESHOLDS.rigid_rotor


class RotorFitError(ValueError):
    """The fit finds no rotor; the text says why."""


@dataclass(frozen=True, eq=False)
class Stage:
    """A window, s, the values of the shots as they were fitted to it alone, and their chi^2."""

    window_s: float
    values: tuple[RotorValues, ...]
    chi2: float


@dataclass(frozen=True, eq=False, kw_only=True)
class RotorFit:
    """A fit of shots together.

    values: of each shot; std: of each shot by name, widened where the residual exceeds the noise; chi2: of each shot;
    dof: of each shot; window_s: the last window; covariance: (k, k) of all free parameters, widened as std; places: of
    each shot's parameters in it, by name; defect: that was free, None: none; stages: the windows that came before.
    """

    shots: tuple[RotorShot, ...]
    values: tuple[RotorValues, ...]
    std: tuple[Mapping[str, float], ...]
    chi2: tuple[float, ...]
    dof: tuple[float, ...]
    window_s: float
    defect: Defect | None
    covariance: Array
    places: tuple[Mapping[str, int], ...]
    stages: tuple[Stage, ...] = ()

    @property
    def chi2_per_dof(self) -> float:
        """Of all shots."""
        return sum(self.chi2) / sum(self.dof)

    @property
    def strength(self) -> tuple[float, float]:
        """Of the defect and its standard deviation, rad or m.  Raises ValueError without one."""
        if self.defect is None:
            raise ValueError("no defect was free in this fit")
        return getattr(self.values[0], self.defect), self.std[0][self.defect]


@dataclass(frozen=True)
class _Layout:
    """Where the free parameters of each shot stand in the common vector."""

    free: tuple[tuple[FreeParameter, ...], ...]
    places: tuple[tuple[int, ...], ...]
    size: int

    @classmethod
    def of(cls, shots: Sequence[RotorShot], defects: Iterable[Defect], held: Sequence[str], window_s: float) -> _Layout:
        free, places, shared, size = [], [], dict[str, int](), 0
        defects = tuple(defects)
        for shot in shots:
            of_shot = tuple(
                p
                for p in free_parameters(shot.geometry, defects, moving=shot.moving)
                if p.name not in held and p.from_s <= window_s
            )
            here = []
            for p in of_shot:
                if p.common and p.name in shared:
                    here.append(shared[p.name])
                    continue
                here.append(size)
                if p.common:
                    shared[p.name] = size
                size += 1
            free.append(of_shot)
            places.append(tuple(here))
        return cls(tuple(free), tuple(places), size)

    def place(self, name: str) -> int:
        """Of a common parameter in the vector."""
        return next(k for p, k in zip(self.free[0], self.places[0], strict=True) if p.name == name)

    def moved(self, values: Sequence[RotorValues], step: Array) -> list[RotorValues]:
        """The values of each shot after a step (size,)."""
        return [
            v.with_numbers({p.name: getattr(v, p.name) + float(step[k]) for p, k in zip(free, places, strict=True)})
            for v, free, places in zip(values, self.free, self.places, strict=True)
        ]

    def prior(self, values: Sequence[RotorValues], first: Sequence[RotorValues]) -> tuple[Array, Array, float]:
        """Weights (size,), pull (size,) towards what was known beforehand, and its chi^2."""
        weight, off = np.zeros(self.size), np.zeros(self.size)
        for v, f, free, places in zip(values, first, self.free, self.places, strict=True):
            for p, k in zip(free, places, strict=True):
                if p.sd is not None:
                    weight[k], off[k] = p.sd**-2, getattr(f, p.name) - getattr(v, p.name)
        return weight, weight * off, float(weight @ off**2)


def longest_s(shots: Sequence[RotorShot]) -> float:
    """Length of the longest ring-down."""
    return max(s.samples.shape[1] / s.rate_hz for s in shots)


def fit_rotor(
    shots: Sequence[RotorShot],
    defect: Defect | None,
    pool: Executor,
    *,
    first_window_s: float = LIMITS.first_window_s,
    held: Sequence[str] = (),
    whole: bool = True,
    beside: RotorFit | None = None,
) -> RotorFit:
    """Fit shots of one specimen together.

    Args:
        shots: with start values.
        defect: the one that is free; the others stay as the start values have them.
        pool: for the columns of the Jacobian.
        first_window_s: of the windows that grow.
        held: names of parameters that are not free.
        beside: a fit with another defect; this one ends where a window's chi^2 rises too far above that one's.
        whole: the window of the whole ring-down frees every parameter; False: only those that its length tells.

    Raises:
        RotorFitError: the start values are far from any rotor, nothing is determined, or `beside` is far better.
    """
    first = [s.values for s in shots]
    free = () if defect is None else (defect,)
    values, longest, stages = list(first), longest_s(shots), []
    for window_s in _windows_s(first_window_s, longest):
        layout = _Layout.of(shots, free, held, window_s if window_s < longest or not whole else math.inf)
        settled_chi2 = LIMITS.settled_chi2 if window_s < longest else LIMITS.found_chi2
        values, matrix, chi2, dof = _settled(shots, layout, values, first, window_s, settled_chi2, pool)
        if window_s == longest:
            break
        stages.append(Stage(window_s, tuple(values), sum(chi2)))
        if beside is not None:
            _still_alike(stages[-1], beside)
    try:
        covariance = np.linalg.inv(matrix)
    except np.linalg.LinAlgError:
        raise RotorFitError("the shots do not determine the rotor's parameters") from None
    wider = math.sqrt(max(1.0, sum(chi2) / sum(dof)))
    covariance = np.asarray(wider**2 * covariance, dtype=np.float64)
    std = np.sqrt(np.abs(np.diag(covariance)))
    return RotorFit(
        shots=tuple(shots),
        values=tuple(values),
        std=tuple(
            {p.name: float(std[k]) for p, k in zip(free, places, strict=True)}
            for free, places in zip(layout.free, layout.places, strict=True)
        ),
        chi2=tuple(chi2),
        dof=tuple(dof),
        window_s=window_s,
        defect=defect,
        covariance=np.asarray(covariance, dtype=np.float64),
        places=tuple(
            {p.name: k for p, k in zip(free, places, strict=True)}
            for free, places in zip(layout.free, layout.places, strict=True)
        ),
        stages=tuple(stages),
    )


def with_errors_of_held(fit: RotorFit, names: Sequence[str], covariance: Array, pool: Executor) -> RotorFit:
    """The fit with errors that contain those of parameters that it held: by how much these move the free ones.

    Args:
        fit: with all of `names` held.
        names: of parameters that `free_parameters` knows.
        covariance: theirs, (names, names), from a fit of other data.
        pool: for the columns of the Jacobian.

    To first order, d free / d held = -(J^T J + prior)^-1 J^T J_held.

    Raises RotorFitError.
    """
    cross = np.zeros((len(fit.covariance), len(names)))
    for shot, values, places in zip(fit.shots, fit.values, fit.places, strict=True):
        known = {p.name: p for p in free_parameters(shot.geometry, DEFECTS, moving=shot.moving)}
        try:
            found = linearised(shot, values, [known[name] for name in (*places, *names)], fit.window_s, pool)
        except (NoRestError, LostRotorError) as error:
            raise RotorFitError(str(error)) from None
        cross[list(places.values())] += found.matrix[: len(places), len(places) :]
    follow = fit.covariance @ cross / max(1.0, fit.chi2_per_dof)
    whole = np.asarray(fit.covariance + follow @ covariance @ follow.T)
    std = np.sqrt(np.abs(np.diag(whole)))
    return replace(
        fit,
        covariance=whole,
        std=tuple({name: float(std[k]) for name, k in places.items()} for places in fit.places),
    )


def _windows_s(first_s: float, longest_s: float) -> list[float]:
    """They grow to the share from which the rest is predicted, and then to the whole."""
    found, share_s = [], LIMITS.predicting_share * longest_s
    while first_s * math.sqrt(LIMITS.window_growth) < share_s:
        found.append(first_s)
        first_s *= LIMITS.window_growth
    return [*found, *([share_s] if found else []), longest_s]


def _still_alike(stage: Stage, beside: RotorFit) -> None:
    """Raises RotorFitError."""
    other = next((s for s in beside.stages if math.isclose(s.window_s, stage.window_s)), None)
    if other is not None and stage.chi2 - other.chi2 > LIMITS.rival_chi2 * max(1.0, beside.chi2_per_dof):
        raise RotorFitError(f"{beside.defect} explains the first {stage.window_s:.3g} s better")


def exchanged(fit: RotorFit, rival: Defect, pool: Executor) -> list[RotorValues]:
    """Start values of each shot for another defect in the place of the one that was free.

    To first order, what the whole window shows of the defect is given to the rival and to all other parameters.
    Raises RotorFitError.
    """
    size, _ = fit.strength
    assert fit.defect is not None
    layout = _Layout.of(fit.shots, (fit.defect, rival), (), math.inf)
    matrix, *_ = _normal_equations(fit.shots, layout, fit.values, fit.window_s, pool)
    matrix[np.diag_indices(layout.size)] += layout.prior(fit.values, fit.values)[0]
    gone = layout.place(fit.defect)
    others = [k for k in range(layout.size) if k != gone]
    step = np.zeros(layout.size)
    step[gone] = -size
    try:
        step[others] = np.linalg.solve(matrix[np.ix_(others, others)], size * matrix[others, gone])
    except np.linalg.LinAlgError:
        raise RotorFitError("the shots do not determine the rotor's parameters") from None
    return layout.moved(fit.values, step)


def _settled(
    shots: Sequence[RotorShot],
    layout: _Layout,
    values: list[RotorValues],
    first: Sequence[RotorValues],
    window_s: float,
    settled_chi2: float,
    pool: Executor,
) -> tuple[list[RotorValues], Array, list[float], list[float]]:
    """Values, J^T J, chi^2 and degrees of freedom of each shot, where chi^2 of a window falls no more."""
    damping, grows = LIMITS.first_damping, LIMITS.damping_grows
    for _ in range(LIMITS.most_steps):
        matrix, gradient, chi2, counts = _normal_equations(shots, layout, values, window_s, pool)
        weight, pull, known = layout.prior(values, first)
        matrix[np.diag_indices(layout.size)] += weight
        gradient += pull
        total = sum(chi2) + known
        moved, fall = False, 0.0
        while damping < LIMITS.most_damping:
            try:
                step = np.linalg.solve(matrix + damping * np.diag(np.diag(matrix)), gradient)
            except np.linalg.LinAlgError:
                raise RotorFitError("the shots do not determine the rotor's parameters") from None
            expected = float(2.0 * gradient @ step - step @ matrix @ step)
            if expected < settled_chi2 and damping <= LIMITS.first_damping:
                break
            trial = layout.moved(values, np.asarray(step, dtype=np.float64))
            fall = total - _cost(shots, layout, trial, first, window_s)
            if fall > 0.0:
                values, moved = trial, True
                damping *= max(LIMITS.damping_falls, 1.0 - (2.0 * fall / expected - 1.0) ** 3)
                grows = LIMITS.damping_grows
                break
            damping, grows = damping * grows, 2.0 * grows
        if not moved or fall < settled_chi2:
            break
    own = layout.size / len(shots)
    return values, matrix, chi2, [count - own for count in counts]


def _cost(
    shots: Sequence[RotorShot],
    layout: _Layout,
    values: Sequence[RotorValues],
    first: Sequence[RotorValues],
    window_s: float,
) -> float:
    """chi^2 with what was known beforehand; infinite where there is no such rotor."""
    try:
        seen = sum(chi2_of(s, v, window_s) for s, v in zip(shots, values, strict=True))
    except (NoRestError, LostRotorError):
        return math.inf
    return seen + layout.prior(values, first)[2]


def _normal_equations(
    shots: Sequence[RotorShot], layout: _Layout, values: Sequence[RotorValues], window_s: float, pool: Executor
) -> tuple[Array, Array, list[float], list[int]]:
    """J^T J (size, size), J^T r (size,), chi^2 and number of residuals of each shot.  Raises RotorFitError."""
    matrix, gradient, chi2, counts = np.zeros((layout.size, layout.size)), np.zeros(layout.size), [], []
    for shot, v, free, places in zip(shots, values, layout.free, layout.places, strict=True):
        try:
            found = linearised(shot, v, free, window_s, pool)
        except (NoRestError, LostRotorError) as error:
            raise RotorFitError(str(error)) from None
        matrix[np.ix_(places, places)] += found.matrix
        gradient[list(places)] += found.gradient
        chi2.append(found.chi2)
        counts.append(found.count)
    return matrix, gradient, chi2, counts
