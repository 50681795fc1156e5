"""Points of a trend: shots of one recording that were made within some minutes are one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import pairwise

import numpy as np

from platform_daemon import estimation  # not its parts, which load numba
from platform_daemon.estimation import RODRIGUES
from platform_daemon.schemas import PARAMETERS
from platform_daemon.store import IndexedRecording, IndexedShot

TOGETHER_S = 600.0
"""Shots of one recording that begin within this are one point."""
LEFT_OUT = ("psi_start_rad",)  # where the swing stands at the first sample says nothing of the specimen


@dataclass(frozen=True)
class Conditions:
    """What values depend on beside the specimen.  fit: window and model; calibration: its name; field_t: of the
    excitation, T."""

    fit: str | None
    calibration: str | None
    field_t: float | None


@dataclass(frozen=True)
class Point:
    """at: ISO 8601, of the first shot; values: means over `shots` shots; temperature_c: mean, NaN: not measured."""

    at: str
    recording: str
    shots: int
    temperature_c: float
    conditions: Conditions
    values: dict[str, float]


def points_of(recordings: Sequence[IndexedRecording]) -> list[Point]:
    """Oldest first.  Orientations are those of one of the mirror images that a ring-down cannot tell apart."""
    groups = [(each, group) for each in recordings for group in _together(each.shots)]
    shots = [shot.values for _, group in groups for shot in group]
    folded = iter(estimation.on_one_branch(shots)[0])
    points = []
    for recording, group in groups:
        values = [next(folded) for _ in group]
        points.append(_point(recording, group, values))
    return sorted(points, key=lambda point: point.at)


def quantities(points: Sequence[Point]) -> list[str]:
    """Names of what the points hold: parameters in the order in which they are told, then the others."""
    names = {name for point in points for name in point.values}
    order = list(PARAMETERS)
    known = sorted(names & set(order), key=order.index)
    return [name for name in [*known, *sorted(names - set(order))] if name not in LEFT_OUT]


def conditions_for(name: str, conditions: Conditions) -> Conditions:
    """Those that a quantity depends on: a change of the others is nothing to its chart.

    A frequency, a damping or a friction needs no calibrated volts, nor one field.
    """
    calibrated = name in ("m_r_am2", "nrmse", *RODRIGUES)
    driven = name in ("phi_max_rad", "nrmse")
    fitted = not name.startswith("noise_")
    return Conditions(
        conditions.fit if fitted else None,
        conditions.calibration if calibrated else None,
        conditions.field_t if driven else None,
    )


def stretches(name: str, points: Sequence[Point]) -> Iterator[slice]:
    """Neighbours under one condition of a quantity."""
    keys = [conditions_for(name, point.conditions) for point in points]
    cuts = [0, *(k + 1 for k, (a, b) in enumerate(pairwise(keys)) if a != b), len(keys)]
    return (slice(a, b) for a, b in pairwise(cuts) if b > a)


def _together(shots: Sequence[IndexedShot]) -> list[list[IndexedShot]]:
    groups: list[list[IndexedShot]] = []
    for shot in shots:
        same = groups and shot.field_t == groups[-1][0].field_t and _later_s(groups[-1][0], shot) < TOGETHER_S
        if groups and same:
            groups[-1].append(shot)
        else:
            groups.append([shot])
    return groups


def _later_s(first: IndexedShot, shot: IndexedShot) -> float:
    return abs((datetime.fromisoformat(shot.at) - datetime.fromisoformat(first.at)).total_seconds())


def _point(recording: IndexedRecording, group: Sequence[IndexedShot], values: Sequence[dict[str, float]]) -> Point:
    names = {name for each in values for name in each}
    means = {name: float(np.mean([each[name] for each in values if name in each])) for name in names}
    measured = [shot.temperature_c for shot in group if shot.temperature_c is not None]
    field = None if group[0].field_t is None else round(group[0].field_t, 9)
    return Point(
        at=group[0].at,
        recording=recording.identifier,
        shots=len(group),
        temperature_c=float(np.mean(measured)) if measured else float("nan"),
        conditions=Conditions(recording.fit, recording.calibration, field),
        values=means,
    )
