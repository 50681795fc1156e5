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
from .shot import Linearised, RotorShot, linearised

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
    def of(cls, shots: Sequence[RotorShot], defects: Iterable[Defect], held: Sequence[str]) -> _Layout:
        free, places, shared, size = [], [], dict[str, int](), 0
        defects = tuple(defects)
        for shot in shots:
            of_shot = tuple(
                p for p in free_parameters(shot.geometry, defects, moving=shot.moving) if p.name not in held
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
    known: Sequence[RotorValues] | None = None,
) -> RotorFit:
    """Fit shots of one specimen together.

    Args:
        shots: with start values.
        defect: the one that is free; the others stay as the start values have them.
        pool: for the columns of the Jacobian.
        first_window_s: of the windows that grow.
        held: names of parameters that are not free.
        known: of each shot what is known beforehand, where that is not what the fit starts with.
        whole: the last window is the whole ring-down; False: it is one of those that grow, so that the fit need not be
            settled to the last digit.

    Raises:
        RotorFitError: the start values are far from any rotor, or nothing is determined.
    """
    values: list[RotorValues] = [s.values for s in shots]
    first = values if known is None else known
    layout = _Layout.of(shots, () if defect is None else (defect,), held)
    longest, stages = longest_s(shots), list[Stage]()
    for window_s in windows_s(first_window_s, longest):
        settled_chi2 = LIMITS.settled_chi2 if window_s < longest or not whole else LIMITS.found_chi2
        values, matrix, chi2, dof = _settled(shots, layout, values, first, window_s, settled_chi2, pool)
        if window_s == longest:
            break
        stages.append(Stage(window_s, tuple(values), sum(chi2)))
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


def windows_s(first_s: float, longest_s: float) -> list[float]:
    """They grow to the share from which the rest is predicted, and then to the whole."""
    found, share_s = [], LIMITS.predicting_share * longest_s
    while first_s * math.sqrt(LIMITS.window_growth) < share_s:
        found.append(first_s)
        first_s *= LIMITS.window_growth
    return [*found, *([share_s] if found else []), longest_s]


def exchanged(fit: RotorFit, rival: Defect, pool: Executor) -> list[RotorValues]:
    """Start values of each shot for another defect in the place of the one that was free.

    To first order, what the whole window shows of the defect is given to the rival and to all other parameters.
    Raises RotorFitError.
    """
    size, _ = fit.strength
    assert fit.defect is not None
    layout = _Layout.of(fit.shots, (fit.defect, rival), ())
    matrix = _normal_equations(fit.shots, layout, fit.values, fit.window_s, pool).matrix
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


@dataclass(frozen=True, eq=False)
class _Normal:
    """Normal equations of all shots at some values.

    matrix: (size, size); gradient: (size,); chi2, counts: of each shot; by_shot: where they were linearised; these may
    be values nearby; fresh: they are these.
    """

    matrix: Array
    gradient: Array
    chi2: list[float]
    counts: list[int]
    by_shot: list[Linearised]
    fresh: bool = True


def _settled(
    shots: Sequence[RotorShot],
    layout: _Layout,
    values: list[RotorValues],
    first: Sequence[RotorValues],
    window_s: float,
    settled_chi2: float,
    pool: Executor,
) -> tuple[list[RotorValues], Array, list[float], list[float]]:
    """Values, J^T J, chi^2 and degrees of freedom of each shot, where chi^2 of a window falls no more.

    A step that does what the Jacobian says is followed by others with the same Jacobian, each for the cost of a motion.
    Steps bend as the valley does, to second order (geodesic acceleration, Transtrum and Sethna, arXiv:1201.5885): along
    it a jewel's f_nat goes with the square of its tilt.
    """
    damping, grows = LIMITS.first_damping, LIMITS.damping_grows
    normal = _normal_equations(shots, layout, values, window_s, pool)
    for _ in range(LIMITS.most_steps):
        weight, pull, known = layout.prior(values, first)
        matrix = normal.matrix + np.diag(weight)
        gradient = normal.gradient + pull
        total = sum(normal.chi2) + known
        moved, fall, expected = False, 0.0, 0.0
        while damping < LIMITS.most_damping:
            try:
                damped = matrix + damping * np.diag(np.diag(matrix))
                step: Array = np.asarray(np.linalg.solve(damped, gradient), dtype=np.float64)
            except np.linalg.LinAlgError:
                raise RotorFitError("the shots do not determine the rotor's parameters") from None
            expected = float(2.0 * gradient @ step - step @ matrix @ step)
            if expected < settled_chi2 and damping <= LIMITS.first_damping:
                break
            bend = _bend(shots, layout, values, normal, step, window_s) if normal.fresh else None
            if bend is not None:
                turn = np.linalg.solve(damped, bend)
                if turn @ matrix @ turn < LIMITS.most_bend**2 * (step @ matrix @ step):
                    step = step + 0.5 * turn
            trial = layout.moved(values, step)
            left = _residuals(shots, trial, window_s)
            fall = total - sum(float(r @ r) for r in left) - layout.prior(trial, first)[2] if left else -math.inf
            if fall > 0.0:
                values, moved = trial, True
                damping *= max(LIMITS.damping_falls, 1.0 - (2.0 * fall / expected - 1.0) ** 3)
                grows = LIMITS.damping_grows
                break
            damping, grows = damping * grows, 2.0 * grows
        if not moved and not normal.fresh and expected >= settled_chi2:  # the old Jacobian leads nowhere
            normal = _normal_equations(shots, layout, values, window_s, pool)
            damping, grows = LIMITS.first_damping, LIMITS.damping_grows
            continue
        if not moved or (fall < settled_chi2 and damping <= LIMITS.first_damping):
            break
        if abs(fall - expected) < LIMITS.same_jacobian * expected:
            normal = _moved(normal, layout, left)
        else:
            normal = _normal_equations(shots, layout, values, window_s, pool)
    own = layout.size / len(shots)
    return values, matrix, normal.chi2, [count - own for count in normal.counts]


def _residuals(shots: Sequence[RotorShot], values: Sequence[RotorValues], window_s: float) -> list[Array]:
    """Of each shot, whitened; none where there is no such rotor."""
    try:
        return [s.residual(v, window_s)[0] for s, v in zip(shots, values, strict=True)]
    except (NoRestError, LostRotorError):
        return []


def _normal_equations(
    shots: Sequence[RotorShot], layout: _Layout, values: Sequence[RotorValues], window_s: float, pool: Executor
) -> _Normal:
    """Linearised at the values.  Raises RotorFitError."""
    by_shot, matrix, gradient = [], np.zeros((layout.size, layout.size)), np.zeros(layout.size)
    for shot, v, free, places in zip(shots, values, layout.free, layout.places, strict=True):
        try:
            found = linearised(shot, v, free, window_s, pool)
        except (NoRestError, LostRotorError) as error:
            raise RotorFitError(str(error)) from None
        matrix[np.ix_(places, places)] += found.matrix
        gradient[list(places)] += found.gradient
        by_shot.append(found)
    return _Normal(matrix, gradient, [one.chi2 for one in by_shot], [one.count for one in by_shot], by_shot)


def _moved(normal: _Normal, layout: _Layout, residuals: Sequence[Array]) -> _Normal:
    """With the Jacobians as they are and other residuals."""
    gradient = np.zeros(layout.size)
    for one, residual, places in zip(normal.by_shot, residuals, layout.places, strict=True):
        gradient[list(places)] += one.columns @ residual.astype(np.float32)
    return replace(normal, gradient=gradient, chi2=[float(r @ r) for r in residuals], fresh=False)


def _bend(
    shots: Sequence[RotorShot],
    layout: _Layout,
    values: Sequence[RotorValues],
    normal: _Normal,
    step: Array,
    window_s: float,
) -> Array | None:
    """-J^T d2 model/ds2 along a step, (size,); None where there is no such rotor."""
    share = LIMITS.probed_share
    left = _residuals(shots, layout.moved(values, share * step), window_s)
    if not left:
        return None
    out = np.zeros(layout.size)
    for one, residual, places in zip(normal.by_shot, left, layout.places, strict=True):
        straight = one.columns.T @ step[list(places)].astype(np.float32)
        second = (2.0 / share) * ((one.residual - residual) / share - straight)
        out[list(places)] -= one.columns @ second.astype(np.float32)
    return out
