"""The charts of all quantities of a specimen."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from platform_daemon.estimation.parameters import RODRIGUES

from .chart import Chart, chart
from .points import Point, places_of, quantities, stretches
from .prediction import Array, temperature_terms
from .schema import TrendChart

SENSED = "f_nat_hz"
"""What a resonator that is calibrated as a sensor is read by: its chart is told in its unit, too."""


@dataclass(frozen=True, eq=False)
class ChartedStretch:
    """The chart of one quantity over points under one condition.

    places: which points, (m,); y: what is charted, logarithms if `logarithmic`.
    """

    quantity: str
    places: NDArray[np.int_]
    y: Array
    logarithmic: bool
    chart: Chart

    def relative_to(self, expected: float) -> float:
        """Factor by which a difference of y becomes relative to the value; one of an orientation stays in rad."""
        absolute = not self.logarithmic and self.quantity not in RODRIGUES
        return 1.0 / max(abs(expected), sys.float_info.min) if absolute else 1.0

    @property
    def expected(self) -> Array:
        """What the points before the change say of each point, as y."""
        learned = self.chart.learned
        return self.chart.terms @ learned.coefficients

    def at_score(self, scores: Array) -> Array:
        """Values (m,), in the unit of the quantity, that lie so many standard deviations beside what is expected."""
        y = self.expected + scores * self.chart.std
        return np.exp(y) if self.logarithmic else y


def charted(points: Sequence[Point], points_to_false_alarm: float) -> list[ChartedStretch]:
    """Every quantity, each over every stretch of one condition."""
    names = quantities(points)
    run_length = min(points_to_false_alarm * max(len(names), 1), 1e7)
    temperatures = np.array([point.temperature_c for point in points])
    shots = np.array([point.shots for point in points], int)
    found, under = [], places_of(points)
    for name in names:
        values = np.array([point.values.get(name, np.nan) for point in points])
        logarithmic = name not in RODRIGUES and bool(np.all(values[np.isfinite(values)] > 0))
        y = np.log(values) if logarithmic else values
        for places in stretches(name, under):
            made = chart(y[places], temperatures[places], run_length, shots[places])
            found.append(ChartedStretch(name, places, y[places], logarithmic, made))
    return found


def shown(
    name: str, stretches_of: Sequence[ChartedStretch], points: Sequence[Point], newest: slice = slice(None)
) -> TrendChart:
    """All stretches of a quantity, each point from its own; temperature and coefficient are those of the newest.

    newest: of the points, which are shown.
    """
    temperature = np.array([point.temperature_c for point in points])
    last = stretches_of[-1]
    known = temperature[last.places][np.isfinite(temperature[last.places])]
    reference_c = float(np.mean(known)) if known.size else None
    corrected = [_corrected(each, temperature[each.places], reference_c) for each in stretches_of]
    slope, std = _coefficient(last, temperature[last.places], reference_c)
    limits = [np.where(np.isfinite(each.chart.ewma), each.chart.limit, np.nan) for each in stretches_of]

    def joined(parts: Sequence[Array]) -> tuple[float, ...]:
        return tuple(in_order(stretches_of, parts)[newest].tolist())

    told = {}
    if name == SENSED:
        spans = {"smoothed": [each.chart.ewma for each in stretches_of], "high": limits, "low": [-x for x in limits]}
        told = {
            key: joined([each.at_score(x) for each, x in zip(stretches_of, scores, strict=True)])
            for key, scores in spans.items()
        }
    return TrendChart(
        quantity=name,
        value=tuple(point.values.get(name, np.nan) for point in points[newest]),
        corrected=joined(corrected),
        reference_c=reference_c,
        relative_per_k=slope,
        relative_per_k_std=std,
        score=joined([each.chart.score for each in stretches_of]),
        ewma=joined([each.chart.ewma for each in stretches_of]),
        limit=joined(limits),
        **told,
    )


def in_order(stretches_of: Sequence[ChartedStretch], parts: Sequence[Array]) -> Array:
    """A value per point of all stretches of a quantity, from the values of each."""
    found = np.empty(sum(map(len, parts)))
    for each, part in zip(stretches_of, parts, strict=True):
        found[each.places] = part
    return found


def _corrected(stretch: ChartedStretch, temperature: Array, reference_c: float | None) -> Array:
    y = stretch.y
    learned = stretch.chart.learned
    if reference_c is not None and learned.std > 0:
        there = _at(temperature, reference_c)
        y = y - (stretch.chart.terms - there) @ learned.coefficients
    return np.exp(y) if stretch.logarithmic else y


def _at(temperature: Array, reference_c: float) -> Array:
    """The row of terms at a temperature, (k,)."""
    return temperature_terms(np.append(temperature[np.isfinite(temperature)][:1], reference_c))[1]


def _coefficient(
    stretch: ChartedStretch, temperature: Array, reference_c: float | None
) -> tuple[float | None, float | None]:
    """d y / d T at the reference temperature and its standard deviation; None if no temperature has taught it."""
    learned = stretch.chart.learned
    known = temperature[np.isfinite(temperature)]
    if reference_c is None or not learned.std > 0 or not known.size or np.ptp(known) == 0.0:
        return None, None
    step = 1.0  # the terms are of second order: a central difference is exact
    slope = (_at(temperature, reference_c + step) - _at(temperature, reference_c - step)) / (2.0 * step)
    there = float(_at(temperature, reference_c) @ learned.coefficients)
    value = float(slope @ learned.coefficients) * stretch.relative_to(there)
    std = float(np.sqrt(slope @ np.linalg.solve(learned.normal, slope)) * learned.std) * stretch.relative_to(there)
    return value, std
