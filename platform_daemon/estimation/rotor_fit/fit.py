"""Damped Gauss-Newton over shots together, in windows that grow.

A window of the whole ring-down has many minima, because the phase of a swing counts hundreds of turns; in a short one
the start values of a single angle are near enough.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.numerics.correlation import samples_per_value
from platform_daemon.estimation.physics.rigid_rotor.rotor import LostRotorError, NoRestError, RotorValues
from platform_daemon.estimation.thresholds import THRESHOLDS

from .layout import Layout
from .parameters import DEFECTS, Defect, free_parameters
from .shot import RotorShot, linearised
from .valley import RotorFitError, Valley, settled

LIMITS = THRESHOLDS.rigid_rotor
CREEP = "creep_m_per_s"


@dataclass(frozen=True, eq=False)
class Stage:
    """A window, s, the values of the shots as they were fitted to it alone, and their chi^2 with what was known."""

    window_s: float
    values: tuple[RotorValues, ...]
    chi2: float


@dataclass(frozen=True, eq=False, kw_only=True)
class RotorFit:
    """A fit of shots together.

    values: of each shot; std: of each shot by name, widened where the residual exceeds the noise; chi2: of each shot;
    dof: of each shot; window_s: the last window; covariance: (k, k) of all free parameters, widened as std, of the
    logarithm of a parameter that is logarithmic; places: of each shot's parameters in it, by name; defect: that was
    free, None: none; known: of each shot beforehand; known_chi2: by how much the values are off that; stages: the
    windows that came before; whole: it was settled as the whole ring-down is, and not only to be compared.
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
    known: tuple[RotorValues, ...]
    known_chi2: float = 0.0
    stages: tuple[Stage, ...] = ()
    whole: bool = True

    @property
    def total_chi2(self) -> float:
        """Of all shots, and of what was known beforehand: of two rotors the one nearer to that is the likelier."""
        return sum(self.chi2) + self.known_chi2

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


def samples_per_value_of(fit: RotorFit) -> float:
    """Samples of what a fit leaves per independent value, mean over the shots by their chi^2.

    Raises NoRestError, LostRotorError.
    """
    rows = [s.residual(v, fit.window_s).reshape(len(s.sd), -1) for s, v in zip(fit.shots, fit.values, strict=True)]
    return float(np.average([samples_per_value(each) for each in rows], weights=fit.chi2))


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
    beside: RotorFit | None = None,
    most_rise: float = LIMITS.rival_chi2,
    to_beat: float = math.inf,
    predicts: bool = True,
    most_chi2_per_dof: float = math.inf,
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
        beside: another fit; this one ends where a window's chi^2 rises too far above that one's.
        most_rise: of chi^2 in a window above that of `beside`, in units of what that leaves.
        to_beat: chi^2 of the last window, above which this fit is of no use: it ends where it will not come below.
        predicts: the last window but one is the share of the ring-down from which the rest is to be predicted.
        most_chi2_per_dof: of a window, above which the fit ends.

    Raises:
        RotorFitError: the start values are far from any rotor, nothing is determined, `beside` is far better, or a
            window leaves too much.
    """
    values: list[RotorValues] = [s.values for s in shots]
    first = values if known is None else known
    layout = Layout.of(shots, () if defect is None else (defect,), held)
    longest, stages = longest_s(shots), list[Stage]()
    for window_s in windows_s(first_window_s, longest, predicts=predicts):
        ends = window_s == longest
        last = whole and ends
        left_chi2 = LIMITS.found_chi2 if last else LIMITS.settled_chi2 * (1.0 if ends else math.sqrt(len(shots)))
        most_chi2 = to_beat if ends else _most_chi2(window_s, beside, most_rise)
        values, matrix, chi2, dof = settled(
            shots, layout, values, first, window_s, last, pool, most_chi2, left_chi2=left_chi2
        )
        if sum(chi2) > most_chi2_per_dof * sum(dof):
            raise RotorFitError(f"this rotor does not explain the first {window_s:.3g} s")
        if ends:
            break
        stages.append(Stage(window_s, tuple(values), sum(chi2) + layout.prior(values, first)[2]))
    matrix = _without_noise(shots, layout, values, first, window_s, matrix, pool)
    found = _stated(shots, layout, values, matrix, chi2, dof, window_s, defect, first)
    return replace(found, stages=tuple(stages), known_chi2=layout.prior(values, first)[2], whole=whole)


def made_whole(fit: RotorFit, pool: Executor) -> RotorFit:
    """A fit that was only to be compared, settled as the whole ring-down is; as it was where that fails."""
    if fit.whole:
        return fit
    begun = [replace(shot, values=values) for shot, values in zip(fit.shots, fit.values, strict=True)]
    free = free_parameters(fit.shots[0].geometry, DEFECTS if fit.defect is None else (fit.defect,), fit.shots[0].start)
    held = [p.name for p in free if p.name not in fit.places[0]]
    try:
        found = fit_rotor(begun, fit.defect, pool, first_window_s=math.inf, held=held, known=fit.known)
    except RotorFitError:
        return replace(fit, whole=True)
    return replace(found, stages=fit.stages)


def expected_fit(
    shot: RotorShot, defect: Defect | None, window_s: float, pool: Executor, *, held: Sequence[str] = ()
) -> RotorFit:
    """What a fit states of a shot that moves with exactly its start values, but for noise: the Cramer-Rao bound.

    Args:
        shot: its samples count, not what they are.
        defect, held: as of `fit_rotor`; what is known beforehand counts as there.
        window_s: from the first sample.
        pool: for the columns of the Jacobian.

    Raises RotorFitError: there is no such rotor, or the shot does not determine it.
    """
    values = [shot.values]
    layout = Layout.of([shot], () if defect is None else (defect,), held)
    normal = Valley([shot], layout, values, window_s).linearised([quiet_values(shot, shot.values)], pool)
    left = float(normal.counts[0] - layout.size)
    return _stated([shot], layout, values, normal.matrix, [left], [left], window_s, defect, values)


def _without_noise(
    shots: Sequence[RotorShot],
    layout: Layout,
    values: Sequence[RotorValues],
    first: Sequence[RotorValues],
    window_s: float,
    matrix: Array,
    pool: Executor,
) -> Array:
    """J^T J with what was known beforehand, from which errors are stated: not as it is, where a contact sticks.

    The motion of a contact that creeps only below a tiny slip is followed to 1e-9 and not better, and in J^T J the
    noise of its differences counts as knowledge: errors came out ten times too small.  A contact that creeps enough
    tells as much of everything but its creep, whose error `_stated` widens to the difference.
    """
    quiet = [quiet_values(s, v) for s, v in zip(shots, values, strict=True)]
    if all(a is b for a, b in zip(quiet, values, strict=True)):
        return matrix
    try:
        return Valley(shots, layout, first, window_s).linearised(quiet, pool).matrix
    except RotorFitError:  # errors may be too small then; the values are none the worse
        return matrix


def quiet_values(shot: RotorShot, values: RotorValues) -> RotorValues:
    """The values with a contact that creeps enough for differences without noise."""
    least = shot.rotor(values).least_quiet_creep_m_per_s
    return values if values.creep_m_per_s >= least else values.with_numbers({CREEP: least})


def _stated(
    shots: Sequence[RotorShot],
    layout: Layout,
    values: Sequence[RotorValues],
    matrix: Array,
    chi2: Sequence[float],
    dof: Sequence[float],
    window_s: float,
    defect: Defect | None,
    known: Sequence[RotorValues],
) -> RotorFit:
    """matrix: J^T J with what was known beforehand.  Raises RotorFitError."""
    try:
        covariance = np.linalg.inv(matrix)
    except np.linalg.LinAlgError:
        raise RotorFitError("the shots do not determine the rotor's parameters") from None
    wider = math.sqrt(max(1.0, sum(chi2) / sum(dof)))
    covariance = np.asarray(wider**2 * covariance, dtype=np.float64)
    for shot, v, free, places in zip(shots, values, layout.free, layout.places, strict=True):
        for p, k in zip(free, places, strict=True):
            if p.name == CREEP:
                apart = p.off(v.creep_m_per_s, quiet_values(shot, v).creep_m_per_s)
                covariance[k, k] = max(covariance[k, k], apart**2)
    std = np.sqrt(np.abs(np.diag(covariance)))
    return RotorFit(
        shots=tuple(shots),
        values=tuple(values),
        std=tuple(
            {p.name: float(std[k]) * p.per_step(getattr(v, p.name)) for p, k in zip(free, places, strict=True)}
            for v, free, places in zip(values, layout.free, layout.places, strict=True)
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
        known=tuple(known),
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
    held_scale = np.array([_scales(fit)[0][name] for name in names])
    for shot, values, places in zip(fit.shots, fit.values, fit.places, strict=True):
        known = {p.name: p for p in free_parameters(shot.geometry, DEFECTS, shot.start)}
        try:
            free = [known[name] for name in (*places, *names)]
            found = linearised(shot, quiet_values(shot, values), free, fit.window_s, pool)
        except (NoRestError, LostRotorError) as error:
            raise RotorFitError(str(error)) from None
        cross[list(places.values())] += found.matrix[: len(places), len(places) :]
    follow = fit.covariance @ cross / max(1.0, fit.chi2_per_dof)
    spread = covariance / np.outer(held_scale, held_scale)
    whole = np.asarray(fit.covariance + follow @ spread @ follow.T)
    std = np.sqrt(np.abs(np.diag(whole)))
    return replace(
        fit,
        covariance=whole,
        std=tuple(
            {name: float(std[k]) * scale[name] for name, k in places.items()}
            for scale, places in zip(_scales(fit), fit.places, strict=True)
        ),
    )


def covariance_of(fit: RotorFit, names: Sequence[str]) -> Array:
    """Of the first shot's parameters with these names, (names, names), none of them as a logarithm."""
    rows, scale = [fit.places[0][name] for name in names], np.array([_scales(fit)[0][name] for name in names])
    return np.asarray(fit.covariance[np.ix_(rows, rows)] * np.outer(scale, scale))


def _scales(fit: RotorFit) -> list[dict[str, float]]:
    """Of each shot, errors of its parameters over those in the covariance, by name."""
    return [
        {p.name: p.per_step(getattr(v, p.name)) for p in free_parameters(s.geometry, DEFECTS, s.start)}
        for s, v in zip(fit.shots, fit.values, strict=True)
    ]


def windows_s(first_s: float, longest_s: float, *, predicts: bool = True) -> list[float]:
    """They grow to the whole; where it is to be predicted, the share from which it is comes before."""
    found, end_s = [], (LIMITS.predicting_share if predicts else 1.0) * longest_s
    while first_s * math.sqrt(LIMITS.window_growth) < end_s:
        found.append(first_s)
        first_s *= LIMITS.window_growth
    if predicts and math.isfinite(first_s) and first_s < longest_s:
        found.append(end_s)
    return [*found, longest_s]


def _most_chi2(window_s: float, beside: RotorFit | None, most_rise: float) -> float:
    """Of a window, from which on a fit is no rival of the one beside it; infinite without one."""
    stages = () if beside is None else beside.stages
    other = next((s for s in stages if math.isclose(s.window_s, window_s)), None)
    if beside is None or other is None:
        return math.inf
    return other.chi2 + most_rise * max(1.0, beside.chi2_per_dof)


def exchanged(
    fit: RotorFit, rival: Defect, pool: Executor, *, gone: Defect | None = None, by: float | None = None
) -> list[RotorValues]:
    """Values of each shot with another defect in the place of one that there is.

    To first order, what the whole window shows of it is given to the rival and to all other parameters.

    Args:
        fit: where it begins.
        rival: the defect that grows.
        pool: for the columns of the Jacobian.
        gone: the one that falls; None: the one that was free.
        by: how much of it falls; None: all of it.

    Raises:
        RotorFitError: the shots do not determine it.
    """
    falls = gone or fit.defect
    assert falls is not None
    size = getattr(fit.values[0], falls) if by is None else by
    layout = Layout.of(fit.shots, (falls, rival), ())
    matrix = Valley(fit.shots, layout, fit.values, fit.window_s).linearised(fit.values, pool).matrix
    place = layout.place(falls)
    others = [k for k in range(layout.size) if k != place]
    step = np.zeros(layout.size)
    step[place] = -size
    try:
        step[others] = np.linalg.solve(matrix[np.ix_(others, others)], size * matrix[others, place])
    except np.linalg.LinAlgError:
        raise RotorFitError("the shots do not determine the rotor's parameters") from None
    return layout.moved(fit.values, step)
