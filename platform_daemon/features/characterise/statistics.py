"""Mean, scatter, median and extremes of a quantity over shots."""

from __future__ import annotations

import math
from collections.abc import Iterable
from statistics import fmean, median, stdev

from platform_daemon.features.fit.series.summary import on_the_circle

from .schema import ShotStatistics


def statistics_of(values: Iterable[float | None], *, circular: bool = False) -> ShotStatistics | None:
    """Over the values that are there; None if none is.

    circular: angles in rad, of which 0 and 2 pi are neighbours; the mean is in 0 .. 2 pi, all others lie around it.
    """
    found = [value for value in values if value is not None and math.isfinite(value)]
    if not found:
        return None
    offset = 0.0
    if circular:
        direction, found = on_the_circle(found)
        mean = fmean(found)
        offset = (mean + direction) % (2.0 * math.pi) - mean
    return ShotStatistics(
        shots=len(found),
        mean=fmean(found) + offset,
        std=stdev(found) if len(found) > 1 else None,
        median=median(found) + offset,
        lowest=min(found) + offset,
        highest=max(found) + offset,
    )
