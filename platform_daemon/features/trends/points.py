"""Points of a trend: shots of one recording that were made within some minutes are one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from platform_daemon.core.recordings.indexed import IndexedPoint, IndexedRecording, IndexedShot
from platform_daemon.core.schemas.base import ClockKind
from platform_daemon.core.schemas.parameters import PARAMETERS
from platform_daemon.estimation.parameters import RODRIGUES

TOGETHER_S = 600.0
"""Shots of one recording that begin within this are one point."""
LEFT_OUT = ("psi_start_rad",)  # the phase at the first sample says nothing of the specimen


@dataclass(frozen=True)
class Conditions:
    """What values depend on apart from the specimen.  fit: window and model; calibration: its name; field_t: of the
    excitation, T."""

    fit: str | None
    calibration: str | None
    field_t: float | None


@dataclass(frozen=True)
class Point:
    """at: ISO 8601, of the first shot; values: means over `shots` shots; temperature_c: mean, NaN: not measured; clock:
    that `at` goes by, None: the file does not say."""

    at: str
    recording: str
    shots: int
    temperature_c: float
    conditions: Conditions
    values: dict[str, float]
    clock: ClockKind | None = None


def points_in(shots: Sequence[IndexedShot]) -> tuple[IndexedPoint, ...]:
    """Those of one recording, by its own mirror image."""
    from platform_daemon.estimation.physics.mirror import on_one_branch

    folded = iter(on_one_branch([shot.values for shot in shots])[0])
    return tuple(_mean(group, [next(folded) for _ in group]) for group in _together(shots))


def points_of(recordings: Sequence[IndexedRecording]) -> list[Point]:
    """Oldest first.  Orientations are those of one of the mirror images that a ring-down cannot tell apart."""
    from platform_daemon.estimation.physics.mirror import on_one_branch

    pairs = [(recording, point) for recording in recordings for point in recording.points]
    folded = on_one_branch([point.values for _, point in pairs])[0]
    made = [_point(*each, values) for each, values in zip(pairs, folded, strict=True)]
    return sorted(made, key=lambda point: point.at)


def quantities(points: Sequence[Point]) -> list[str]:
    """Names of the quantities of the points: parameters in the order of their table, then the others."""
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


def places_of(points: Sequence[Point]) -> dict[Conditions, list[int]]:
    """Places of the points under each conditions."""
    found: dict[Conditions, list[int]] = {}
    for place, point in enumerate(points):
        found.setdefault(point.conditions, []).append(place)
    return found


def stretches(name: str, places: Mapping[Conditions, Sequence[int]]) -> list[NDArray[np.int_]]:
    """Places of the points under each condition of a quantity, that of the newest point last.

    They may alternate: a single fit over another window must not discard what was learned in months.
    """
    found: dict[Conditions, list[int]] = {}
    for conditions, here in places.items():
        found.setdefault(conditions_for(name, conditions), []).extend(here)
    return sorted((np.sort(here) for here in found.values()), key=lambda here: int(here[-1]))


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


def _mean(group: Sequence[IndexedShot], values: Sequence[Mapping[str, float]]) -> IndexedPoint:
    names = dict.fromkeys(name for each in values for name in each)
    measured = [shot.temperature_c for shot in group if shot.temperature_c is not None]
    return IndexedPoint(
        at=group[0].at,
        shots=len(group),
        temperature_c=float(np.mean(measured)) if measured else None,
        field_t=group[0].field_t,
        values={name: float(np.mean([each[name] for each in values if name in each])) for name in names},
    )


def _point(recording: IndexedRecording, point: IndexedPoint, values: dict[str, float]) -> Point:
    field = None if point.field_t is None else round(point.field_t, 9)
    return Point(
        at=point.at,
        recording=recording.identifier,
        shots=point.shots,
        temperature_c=float("nan") if point.temperature_c is None else point.temperature_c,
        conditions=Conditions(recording.fit, recording.calibration, field),
        values=values,
        clock=recording.clock,
    )
