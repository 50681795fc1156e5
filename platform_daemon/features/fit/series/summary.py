"""Mean and scatter of each parameter over the frames of a series."""

from __future__ import annotations

import math
from collections.abc import Iterable
from statistics import fmean, stdev

from platform_daemon.core.schemas.fits import FrameFit, ParameterSummary
from platform_daemon.core.schemas.parameters import names_in_order
from platform_daemon.estimation.parameters import RODRIGUES
from platform_daemon.estimation.physics.mirror import on_one_branch


def summary(frames: Iterable[FrameFit]) -> dict[str, ParameterSummary]:
    """Mean and scatter of each parameter over the good frames; std None for one frame.

    Every frame counts by its nearer mirror solution; psi is averaged on the circle, orientations as rotations.
    """
    rows, mean = on_one_branch([frame.values for frame in frames if frame.good])
    # Of the rotations: components have no mean.
    means = {} if mean is None else dict(zip(RODRIGUES, mean.tolist(), strict=True))
    result = {}
    for name in names_in_order({name for row in rows for name in row}):
        values = [row[name] for row in rows if name in row]
        middle, std = _mean_and_scatter(values, circular=name == "psi_start_rad")
        result[name] = ParameterSummary(mean=means.get(name, middle), std=std)
    return result


def _mean_and_scatter(values: list[float], *, circular: bool) -> tuple[float, float | None]:
    offset, values = on_the_circle(values) if circular else (0.0, values)
    mean = fmean(values) + offset
    return mean % (2 * math.pi) if circular else mean, stdev(values) if len(values) > 1 else None


def on_the_circle(angles: list[float]) -> tuple[float, list[float]]:
    """The mean direction of angles, rad, and what they differ from it by: so 0 and 2 pi are neighbours."""
    offset = math.atan2(fmean(map(math.sin, angles)), fmean(map(math.cos, angles)))
    return offset, [math.remainder(angle - offset, 2 * math.pi) for angle in angles]
