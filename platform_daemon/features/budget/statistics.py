"""What fits say by themselves: scatter or noise of their parameters, and what the two windows disagree by."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean

import numpy as np
from numpy.typing import NDArray

from platform_daemon.core.schemas.fits import FrameFit
from platform_daemon.estimation.physics.mirror import on_one_branch
from platform_daemon.features.fit.series.summary import on_the_circle, summary
from platform_daemon.uncertainty.budget import NotDeclared
from platform_daemon.uncertainty.inputs import InputQuantity

from .influences import Effect, Situation
from .thresholds import CORRELATED_SD, DISAGREE_SD

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Statistics:
    """What the fits themselves say: values (m,), their covariance by noise or scatter (m, m) with its name and degrees
    of freedom; difference (m,): N50 minus D30, difference_std (m,); None: not known."""

    names: tuple[str, ...]
    values: Array
    covariance: Array
    name: str
    source: str
    dof: float
    difference: Array | None
    difference_std: Array | None

    @property
    def model_u(self) -> Array:
        """Standard uncertainty, (m,), by the disagreement of N50 and D30: the truth may lie between them or as far
        beyond D30."""
        if self.difference is None or self.difference_std is None:
            return np.zeros(len(self.names))
        seen = np.abs(self.difference) > DISAGREE_SD * self.difference_std
        return np.where(seen, np.abs(self.difference) / math.sqrt(3.0), 0.0)


def scatter_of(reports: Sequence[FrameFit], given: Situation, temperatures: Sequence[float | None]) -> Statistics:
    """Mean and covariance of the mean of good fits, which belongs to the mean temperature: what the thermometer
    explains of the scatter, at declared coefficients, is taken out.  temperatures: of each, degrees Celsius."""
    names, n = given.names, len(reports)
    means = summary(reports)
    deviations = _deviations(names, [report.values for report in reports])
    said = ""
    if all(t is not None for t in temperatures):
        known = np.array(temperatures, float)
        slopes = np.array([given.declared.temperature_coefficient_per_k.get(name, 0.0) for name in names])
        if slopes.any():
            deviations = deviations - np.outer(known - known.mean(), slopes)
            said = " at their mean temperature"
    covariance = deviations.T @ deviations / (n - 1)
    counts = np.array([independent(column) for column in deviations.T])
    count = np.sqrt(np.outer(counts, counts))
    values = np.array([means[name].mean for name in names])
    fewest = float(counts.min())
    source = f"mean of {n} shots{said}"
    if fewest < n - 0.5:
        source += f", of which neighbours are alike: as {fewest:.1f} independent ones where that is strongest"
    return Statistics(names, values, covariance / count, "scatter", source, max(1.0, fewest - 1.0), None, None)


def independent(deviations: Array) -> float:
    """How many independent shots have a mean as uncertain: n (1 - r) / (1 + r) for a lag-1 autocorrelation r."""
    n, power = len(deviations), float(deviations @ deviations)
    if power == 0.0:
        return float(n)
    r = float(deviations[1:] @ deviations[:-1]) / power
    return float(n) if r < CORRELATED_SD / math.sqrt(n) else max(2.0, n * (1.0 - r) / (1.0 + r))


def _deviations(names: Sequence[str], rows: Sequence[dict[str, float]]) -> Array:
    """From the mean, (n, m), on one of the mirror images that a ring-down cannot tell apart."""
    folded, _ = on_one_branch(rows)
    columns = []
    for name in names:
        values = [row[name] for row in folded]
        if name == "psi_start_rad":
            _, values = on_the_circle(values)
        columns.append(np.array(values) - fmean(values))
    return np.stack(columns, axis=1)


def differences(names: Sequence[str], long: Sequence[FrameFit], short: Sequence[FrameFit]) -> tuple[Array, Array]:
    """Mean of N50 minus D30, and its standard deviation; NaN for what only N50 holds.

    The longer window contains the shorter one: of an efficient estimator the variance of the difference is the
    difference of the variances (Hausman, Econometrica 46 (1978) 1251).
    """
    folded, _ = on_one_branch([*(each.values for each in long), *(each.values for each in short)])
    n = len(long)
    rows = [[b[name] - a[name] for name in names] for a, b in zip(folded[:n], folded[n:], strict=True)]
    found = np.array(rows)
    if "psi_start_rad" in names:
        k = names.index("psi_start_rad")
        found[:, k] = np.remainder(found[:, k] + math.pi, 2.0 * math.pi) - math.pi
    variances = [
        [(b.parameters[name].std or 0.0) ** 2 - (a.parameters[name].std or 0.0) ** 2 for name in names]
        for a, b in zip(long, short, strict=True)
    ]
    own = np.sqrt(np.maximum(np.mean(variances, axis=0), 0.0) / n)
    held = [short[0].parameters[name].std is None and long[0].parameters[name].std is not None for name in names]
    return np.where(held, np.nan, found.mean(axis=0)), np.where(held, np.nan, own)


def explained(long: Sequence[Effect], short: Sequence[Effect]) -> Array:
    """Standard deviation, (m,), of N50 minus D30 by what is declared: an error of a gain moves the two differently."""
    parts = [(b.effects - a.effects) * a.known.u for a, b in zip(long, short, strict=True) if a.known is not None]
    return np.sqrt(np.sum(np.square(parts), axis=0)) if parts else np.zeros(len(long[0].effects))


def add_model(k: int, told: Statistics, lines: list[tuple[InputQuantity, float]], missing: list[NotDeclared]) -> None:
    """The line of what the two windows disagree by for parameter `k`, or why there is none."""
    if told.difference is None or told.difference_std is None:
        missing.append(NotDeclared("model (it is seen where D30 and N50 are both fitted)", math.nan))
        return
    difference, std = float(told.difference[k]), float(told.difference_std[k])
    if math.isnan(difference):
        missing.append(NotDeclared("model (N50 holds the parameter)", math.nan))
        return
    if (u := float(told.model_u[k])) > 0.0:
        source = f"N50 minus D30 is {difference:.3g}, its noise {std:.2g}"
        lines.append((InputQuantity(name="model", value=0.0, u=u, distribution="rectangular", source=source), 1.0))
    elif std > 0.0:
        what = "model (N50 and D30 agree), per standard deviation of their difference"
        missing.append(NotDeclared(what, std, looked_for=True))
