"""Calibration of an instrument against a reference: regression with errors in both variables, its checks, its inverse.

An instrument answers f = g(x; p) + c (t - t0) to a quantity x, t being a second influence as the temperature.  Both f
and the reference's x have errors, so that the sum of both squared errors over their variances is made smallest (Fuller,
Measurement Error Models, Wiley 1987, 3.2; ISO/TS 28037 for the straight line).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drivers.errors import InputError

from .budget import Budget, combine
from .curves import Curve
from .inputs import Array, InputQuantity

_ITERATIONS = 200
_CONVERGED = 1e-7  # of the standard uncertainties of the parameters: the last step
_CHANCE = 0.01  # of chi^2, beyond which on either side the uncertainties of the points do not explain it
_ROUNDS = 6  # of scatter and fit: the scatter changes by less than a percent after three
_PLACES = 400  # at which a curve is looked at for a turning point


@dataclass(frozen=True, eq=False)
class Points:
    """Pairs of a reference and an instrument, in the order of time.

    Attributes:
        x, u_x: (n,) of the reference, with the standard uncertainty of each reading by itself.
        f, u_f: (n,) of the instrument, with the smallest standard uncertainty of each; more is found as scatter.
        second: (n,) second influence, None: there is none.
    """

    x: Array
    u_x: Array
    f: Array
    u_f: Array
    second: Array | None = None

    def some(self, places: NDArray[np.intp]) -> Points:
        """Of these places."""
        second = None if self.second is None else self.second[places]
        return Points(self.x[places], self.u_x[places], self.f[places], self.u_f[places], second)


@dataclass(frozen=True, kw_only=True, eq=False)
class Trend:
    """Something that a calibration does not contain, tested on what it leaves over.

    Attributes:
        value, u: of it, in the unit of f; probability: that chance makes as much (two-sided t test).
    """

    value: float
    u: float
    probability: float


@dataclass(frozen=True, kw_only=True, eq=False)
class CalibratedCurve:
    """A calibration.

    Attributes:
        curve: its form; parameters, covariance: (k,), (k, k) of it, the last one c if there is a second influence.
        second_at: t0, at which the curve itself holds; None: there is no second influence.
        x_range, second_range: within which it was calibrated.
        scatter: standard deviation of f from reading to reading; dof: degrees of freedom of it.
        chi2_per_dof: of the regression with that scatter: 1 where the scatter was found, less where u_f explains more.
    """

    curve: Curve
    parameters: Array
    covariance: Array
    x_range: tuple[float, float]
    scatter: float
    dof: float
    chi2_per_dof: float
    second_at: float | None = None
    second_range: tuple[float, float] | None = None

    def value(self, x: Array, second: Array | None = None) -> Array:
        """f (n,) at x (n,)."""
        own = len(self.curve.names)
        found = self.curve.value(self.parameters[:own], x)
        if self.second_at is None or second is None:
            return found
        return found + self.parameters[own] * (second - self.second_at)

    def slope(self, x: Array) -> Array:
        """df/dx (n,)."""
        return self.curve.slope(self.parameters[: len(self.curve.names)], x)

    def gradient(self, x: Array, second: Array | None = None) -> Array:
        """df by the parameters, (n, k)."""
        rows = self.curve.gradient(self.parameters[: len(self.curve.names)], x)
        if self.second_at is None:
            return rows
        assert second is not None
        return np.column_stack([rows, second - self.second_at])

    def inverse(self, f: float, second: float | None = None, *, within: tuple[float, float] | None = None) -> float:
        """x at which the instrument answers f; within: where it is looked for, None: the range of the calibration.

        Raises InputError if there is no such x there.
        """
        from scipy.optimize import brentq

        low, high = within or self.x_range
        extra = None if second is None else np.array([second])

        def excess(x: float) -> float:
            return float(self.value(np.array([x]), extra)[0] - f)

        ends = excess(low), excess(high)
        if not ends[0] * ends[1] <= 0.0:
            what = f"{f:.9g} is outside of what the instrument answers from {low:g} to {high:g}"
            why = f"there it answers {ends[0] + f:.9g} to {ends[1] + f:.9g}"
            remedy = "calibrate over a wider range, or ask for an extrapolation and judge it"
            raise InputError(what, where="measurand", why=why, remedy=remedy)
        return float(brentq(excess, low, high, xtol=1e-12 * (abs(low) + abs(high)) + 1e-300))

    def read(
        self,
        quantity: str,
        f: float,
        second: float | None = None,
        *,
        readings: int = 1,
        u_second: float = 0.0,
        common: tuple[InputQuantity, ...] = (),
        coverage: float = 0.95,
        within: tuple[float, float] | None = None,
        x: float | None = None,
    ) -> Budget:
        """x, with its budget, for a reading f or the mean of several.

        second: the second influence then; u_second: its standard uncertainty, apart from what it had in common with
        the calibration.  common: further inputs, in the unit of x.  within: see `inverse`.  x: what `inverse` has
        found, if it was asked before.  Raises InputError.
        """
        x = self.inverse(f, second, within=within) if x is None else x
        at, extra = np.array([x]), None if second is None else np.array([second])
        slope = float(self.slope(at)[0])
        row = self.gradient(at, extra)[0]
        scatter = self.scatter / math.sqrt(readings)
        source = f"readings against the calibration, {readings} of them" if readings > 1 else "one reading"
        inputs = [InputQuantity(name="scatter", value=f, u=scatter, kind="A", dof=self.dof, source=source)]
        slopes = [1.0 / slope]
        if (u := math.sqrt(float(row @ self.covariance @ row))) > 0.0:
            source = "covariance of its parameters"
            inputs.append(InputQuantity(name="calibration", value=0.0, u=u, kind="A", dof=self.dof, source=source))
            slopes.append(-1.0 / slope)
        if second is not None and u_second > 0.0 and self.second_at is not None:
            inputs.append(InputQuantity(name="second influence", value=second, u=u_second))
            slopes.append(-float(self.parameters[-1]) / slope)
        return combine(quantity, x, [*inputs, *common], np.array([*slopes, *(1.0 for _ in common)]), coverage=coverage)


def fit_curve(curve: Curve, points: Points) -> CalibratedCurve:
    """The calibration that points (n) give.

    The scatter of f is found from what the regression leaves over; neighbours that are alike count as fewer.  Raises
    InputError for fewer points than parameters and two more, and for a curve that the points do not determine.
    """
    n = len(points.x)
    wanted = len(curve.names) + (points.second is not None)
    if n < wanted + 2:
        remedy = "record more, or choose a model with fewer parameters"
        why = "a scatter needs two more"
        pairs = "1 pair" if n == 1 else f"{n} pairs"
        raise InputError(f"{pairs} for {wanted} parameters", where="reference", why=why, remedy=remedy)
    if float(np.ptp(points.x)) == 0.0:
        remedy = "let the reference change while it is calibrated"
        raise InputError("the reference has one value only", where="reference", remedy=remedy)
    second_at = None if points.second is None else float(points.second.mean())
    scatter = np.zeros(n)
    # With too small variances the errors of x would have to explain everything, and the minimum is not found.
    first = points.f - curve.value(curve.start(points.x, points.f), points.x)
    found = _minimum(curve, points, second_at, np.hypot(points.u_f, float(first.std())))
    for _ in range(_ROUNDS):
        left, slopes = found[2], found[4]
        scatter = np.full(n, _more_variance(left, points.u_f**2 + (slopes * points.u_x) ** 2, n - wanted))
        found = _minimum(curve, points, second_at, np.sqrt(points.u_f**2 + scatter))
    parameters, covariance, left, weights, _ = found
    count = n / independent(left * np.sqrt(weights))
    second = points.second
    return CalibratedCurve(
        curve=curve,
        parameters=parameters,
        covariance=covariance * count,
        x_range=(float(points.x.min()), float(points.x.max())),
        scatter=math.sqrt(float(np.mean(points.u_f**2)) + float(scatter[0])),
        dof=float(n - wanted),
        chi2_per_dof=float((left**2) @ weights) / (n - wanted),
        second_at=second_at,
        second_range=None if second is None else (float(second.min()), float(second.max())),
    )


def _more_variance(left: Array, explained: Array, dof: int) -> float:
    """The variance that all residuals have beyond what is known of each: the difference of the means.  Where a few that
    are known badly decide it, that of which chi^2 is dof (Paule and Mandel, J. Res. NBS 87 (1982) 377)."""
    from scipy.optimize import brentq
    from scipy.special import chdtri

    def chi2(more: float) -> float:
        return float(np.sum(left**2 / (explained + more)))

    mean = float(left @ left) / dof
    more, least = max(0.0, mean - float(explained.mean())), 1e-12 * mean
    low, high = chdtri(dof, 1.0 - _CHANCE) if more > 0.0 else 0.0, chdtri(dof, _CHANCE)
    if mean == 0.0 or low <= chi2(max(more, least)) <= high:
        return more
    return float(brentq(lambda x: chi2(x) - dof, least, mean)) if chi2(least) > dof else 0.0


def independent(residuals: Array) -> float:
    """How many independent residuals say as much: n (1 - r) / (1 + r) for a lag-1 autocorrelation r above chance."""
    n, power = len(residuals), float(residuals @ residuals)
    if power == 0.0:
        return float(n)
    r = float(residuals[1:] @ residuals[:-1]) / power
    return float(n) if r < 2.0 / math.sqrt(n) else max(2.0, n * (1.0 - r) / (1.0 + r))


def _minimum(
    curve: Curve, points: Points, second_at: float | None, u_f: Array
) -> tuple[Array, Array, Array, Array, Array]:
    """Parameters, covariance, f minus curve (n,), weights 1 / u^2 of it (n,), and slopes (n,), at the minimum."""
    own, x = len(curve.names), points.x.copy()
    theta = curve.start(points.x, points.f)
    beside = None if points.second is None or second_at is None else points.second - second_at
    if beside is not None:
        theta = np.append(theta, 0.0)

    def rows(at: Array) -> Array:
        gradient = curve.gradient(theta[:own], at)
        return gradient if beside is None else np.column_stack([gradient, beside])

    for _ in range(_ITERATIONS):
        slopes = curve.slope(theta[:own], x)
        value = curve.value(theta[:own], x)
        if beside is not None:
            value = value + theta[own] * beside
        weights = 1.0 / (u_f**2 + (slopes * points.u_x) ** 2)
        jacobian = rows(x)
        left = points.f - value - slopes * (points.x - x)
        if not (np.isfinite(jacobian).all() and np.isfinite(weights).all() and np.isfinite(left).all()):
            break  # beyond a pole of the curve
        scale = np.linalg.norm(jacobian * np.sqrt(weights)[:, None], axis=0)
        step, _, rank, _ = np.linalg.lstsq(jacobian * np.sqrt(weights)[:, None] / scale, left * np.sqrt(weights))
        if rank < len(theta) or not np.isfinite(step).all():
            break
        theta = theta + step / scale
        x = points.x + slopes * points.u_x**2 * weights * (left - jacobian @ (step / scale))
        normal = (jacobian / scale).T @ ((jacobian / scale) * weights[:, None])
        covariance = np.linalg.inv(normal) / np.outer(scale, scale)
        if (np.abs(step / scale) <= _CONVERGED * np.sqrt(covariance.diagonal())).all():
            return theta, covariance, left, weights, slopes
    why = "the pairs do not determine all of its parameters"
    remedy = "choose a model with fewer parameters, or vary the reference more"
    raise InputError("the curve cannot be fitted", where="measurand", why=why, remedy=remedy)


def turning_points(found: CalibratedCurve) -> tuple[float, ...]:
    """Where within its range f turns, so that two x have the same f."""
    x = np.linspace(*found.x_range, _PLACES)
    signs = np.sign(found.slope(x))
    return tuple(x[1:][signs[1:] != signs[:-1]].tolist())


def one_branch(found: CalibratedCurve, within: tuple[float, float]) -> tuple[float, float]:
    """The part of `within` about the range of the calibration where f does not turn and is a number: beyond, an f
    belongs to two x, or to none."""
    x = np.linspace(*within, 4 * _PLACES)
    rising = float(found.slope(np.array([0.5 * (found.x_range[0] + found.x_range[1])]))[0])
    wrong = ~(found.slope(x) * rising > 0.0)
    below, above = wrong & (x < found.x_range[0]), wrong & (x > found.x_range[1])
    low = within[0] if not below.any() else min(found.x_range[0], float(x[np.flatnonzero(below)[-1] + 1]))
    high = within[1] if not above.any() else max(found.x_range[1], float(x[np.flatnonzero(above)[0] - 1]))
    return low, high


def left_over(found: CalibratedCurve, points: Points) -> Array:
    """f minus the calibration, (n,)."""
    return points.f - found.value(points.x, points.second)


def trend_in(found: CalibratedCurve, points: Points, column: Array) -> Trend:
    """Whether f contains a column (n,) that the calibration does not: its coefficient and the chance of as much."""
    from scipy.special import stdtr

    jacobian = np.column_stack([found.gradient(points.x, points.second), column])
    slopes = found.slope(points.x)
    weights = 1.0 / (found.scatter**2 + (slopes * points.u_x) ** 2)
    root = np.sqrt(weights)
    scale = np.linalg.norm(jacobian * root[:, None], axis=0)
    scale[scale == 0.0] = 1.0
    left = left_over(found, points)
    inverse = np.linalg.pinv((jacobian / scale).T @ ((jacobian / scale) * weights[:, None]))
    coefficients = inverse @ ((jacobian / scale).T @ (left * weights))
    value = float(coefficients[-1] / scale[-1])
    # Without what is tested the rest is smaller, and neighbours are less alike.
    rest = (left - (jacobian / scale) @ coefficients) * root
    spread = float(rest @ rest) / (found.dof - 1.0)
    u = math.sqrt(float(inverse[-1, -1]) * spread * len(left) / independent(rest)) / scale[-1]
    chance = 1.0 if u == 0.0 else 2.0 * float(stdtr(found.dof - 1.0, -abs(value) / u))
    return Trend(value=value, u=u, probability=chance)


def with_lag(
    curve: Curve, points_at: Callable[[float], Points], longest: float
) -> tuple[CalibratedCurve, Points, float, float]:
    """The calibration at the lag of the reference that explains the readings best, in s, with its standard deviation.

    points_at: the pairs for a lag, as many for each of them; longest: lags up to that, of either sign, s.  Raises
    InputError as `fit_curve` does, and for a lag at an end of what is allowed.
    """
    from scipy.optimize import minimize_scalar

    def misfit(lag: float) -> float:
        points = points_at(lag)
        found = fit_curve(curve, points)
        spread = found.scatter**2 + (found.slope(points.x) * points.u_x) ** 2
        return float(np.sum(np.log(spread)) + np.sum(left_over(found, points) ** 2 / spread))

    grid = np.linspace(-longest, longest, 21)
    at = grid[int(np.argmin([misfit(lag) for lag in grid]))]
    step = grid[1] - grid[0]
    best = minimize_scalar(misfit, bounds=(at - step, at + step), method="bounded", options={"xatol": 1e-3 * step})
    lag = float(best.x)
    if abs(lag) > 0.98 * longest:
        remedy = "allow a longer lag, or check the time zone and the clock of the reference"
        raise InputError(f"the lag of the reference is {longest:g} s or more", where="reference", remedy=remedy)
    points = points_at(lag)
    found = fit_curve(curve, points)
    by_lag = (points_at(lag + 0.01 * step).x - points_at(lag - 0.01 * step).x) / (0.02 * step)
    found, u_lag = _with_lag_column(found, points, by_lag)
    return found, points, lag, u_lag


def _with_lag_column(found: CalibratedCurve, points: Points, by_lag: Array) -> tuple[CalibratedCurve, float]:
    """The covariance with the lag as a parameter more, and the standard deviation of the lag."""
    slopes = found.slope(points.x)
    weights = 1.0 / (found.scatter**2 + (slopes * points.u_x) ** 2)
    jacobian = np.column_stack([found.gradient(points.x, points.second), slopes * by_lag])
    scale = np.linalg.norm(jacobian, axis=0)
    if scale[-1] == 0.0:
        return found, math.inf
    normal = (jacobian / scale).T @ ((jacobian / scale) * weights[:, None])
    inflated = len(points.x) / independent(left_over(found, points) * np.sqrt(weights))
    whole = inflated * np.linalg.pinv(normal) / np.outer(scale, scale)
    return replace(found, covariance=whole[:-1, :-1], dof=found.dof - 1.0), math.sqrt(float(whole[-1, -1]))
