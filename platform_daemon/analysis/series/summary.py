"""Mean and scatter of each parameter over the frames of a series."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from statistics import fmean, stdev
from typing import Any

from platform_daemon.estimation import RODRIGUES, on_one_branch

from ..fit_request import names_in_order

Row = dict[str, float | None]


def summary(frames: Iterable[Mapping[str, Any]]) -> dict[str, Row]:
    """Mean and scatter of each parameter over the good frames; std None for one frame.

    Every frame counts by its nearer twin (estimation/physics/mirror.py); psi is averaged on the circle, orientations as
    rotations.
    """
    good = [f["parameters"] for f in frames if f["verdict"] == "good"]
    rows, mean = on_one_branch([{name: estimate["value"] for name, estimate in p.items()} for p in good])
    result: dict[str, Row] = {}
    for name in names_in_order({name for row in rows for name in row}):
        values = [row[name] for row in rows if name in row]
        result[name] = _mean_and_scatter(values, circular=name == "psi_start_rad")
    if mean is not None:
        for name, component in zip(RODRIGUES, mean.tolist(), strict=True):
            result[name]["mean"] = component  # of the rotations: components have no mean
    return result


def _mean_and_scatter(values: list[float], *, circular: bool) -> Row:
    offset = 0.0
    if circular:  # turn the mean direction to zero so that 0 and 2 pi are neighbours
        offset = math.atan2(fmean(map(math.sin, values)), fmean(map(math.cos, values)))
        values = [math.remainder(v - offset, 2 * math.pi) for v in values]
    mean = fmean(values) + offset
    mean = mean % (2 * math.pi) if circular else mean
    return {"mean": mean, "std": stdev(values) if len(values) > 1 else None}
