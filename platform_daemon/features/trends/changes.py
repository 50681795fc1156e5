"""What a change is called: which quantities have moved together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from platform_daemon.core.schemas.parameters import definition_of
from platform_daemon.estimation.parameters import RODRIGUES

from .charts import ChartedStretch, in_order
from .points import Point
from .schema import ChangeName, TrendChange

_MOVED = 2.6
"""Mean of the scores of another quantity since the change, over its standard deviation: beyond it moves along."""


@dataclass(frozen=True)
class _Noticed:
    """An alarm of a chart. first, noticed: places among all points; up: it has grown."""

    stretch: ChartedStretch
    first: int
    noticed: int
    up: bool
    stands: bool


def changes(stretches: Sequence[ChartedStretch], points: Sequence[Point]) -> list[TrendChange]:
    """Sorted by the time at which they were noticed; a change that several charts show is listed once."""
    noticed = sorted(filter(None, map(_noticed, stretches)), key=lambda each: each.noticed)
    by_quantity: dict[str, list[ChartedStretch]] = {}
    for each in stretches:
        by_quantity.setdefault(each.quantity, []).append(each)
    found: list[TrendChange] = []
    explained: set[str] = set()
    for alarm in noticed:
        quantity = alarm.stretch.quantity
        if quantity in explained:
            continue
        name, along, what = _named(alarm, _moves(alarm, by_quantity))
        explained |= {quantity, *along}
        stands = alarm.stands or any(o.stands for o in noticed if o.stretch.quantity in along)
        found.append(_told(name, what, alarm, along, points, stands=stands))
    return found


def _noticed(stretch: ChartedStretch) -> _Noticed | None:
    alarm = stretch.chart.alarm
    if alarm is None:
        return None
    first, noticed = (int(stretch.places[k]) for k in (alarm.since, alarm.noticed))
    return _Noticed(stretch, first, noticed, alarm.shift > 0, alarm.stands)


def _moves(change: _Noticed, stretches: Mapping[str, Sequence[ChartedStretch]]) -> dict[str, float]:
    """How far each quantity has moved since the change, in standard deviations of the mean of its scores."""
    found = {}
    for name, parts in stretches.items():
        scores = in_order(parts, [part.chart.score for part in parts])[change.first :]
        scores = scores[np.isfinite(scores)]
        if scores.size:
            found[name] = float(scores.mean() * np.sqrt(scores.size))
    return found


def _named(change: _Noticed, moves: Mapping[str, float]) -> tuple[ChangeName, tuple[str, ...], str]:
    """Name, the other quantities that belong to it, and words with a remedy."""
    quantity, up = change.stretch.quantity, change.up
    noises = tuple(name for name, moved in moves.items() if name.startswith("noise_") and moved > _MOVED)
    falls = [name for name in ("f_nat_hz", "m_r_am2") if moves.get(name, 0.0) < -_MOVED]
    if quantity in ("f_nat_hz", "m_r_am2") and len(falls) == 2:
        other = "m_r_am2" if quantity == "f_nat_hz" else "f_nat_hz"
        why = "f_nat and m_r fall together: the magnets have lost magnetisation"
        return "lost_magnetisation", (other,), f"{why}. Keep heat and strong fields away; calibrate what relies on it"
    if quantity == "tf_over_i_rad_per_s2" and up:
        along = tuple(n for n in ("lambda_per_s", "nrmse") if abs(moves.get(n, 0.0)) > _MOVED)
        return "wear", along, "T_f/I grows: the bearing wears. Look at jewel and pivot; plan its replacement"
    if quantity.startswith("noise_") and up:
        along = tuple(n for n in (*noises, "nrmse") if n != quantity and moves.get(n, 0.0) > _MOVED)
        channels = ", ".join(sorted(n.split("_")[1] for n in {quantity, *noises}))
        return "noise_source", along, f"noise outside the ring-down has grown on {channels}. Find what was switched on"
    if quantity == "nrmse" and up and noises:
        return "noise_source", noises, "the residual and the noise grow together. Find what was switched on"
    if quantity == "nrmse" and up:
        what = "the model leaves more over while the noise is as it was: a new side mode, or an effect the model lacks"
        return "side_mode", (), f"{what}. Diagnose recordings from before and after"
    if quantity in RODRIGUES:
        along = tuple(name for name in RODRIGUES if name != quantity)
        return "turned", along, "the rotor lies in another direction. Check the mount"
    if quantity == "m_r_am2":
        what = "m_r has changed and f_nat has not: a gain, a coil or the calibration, rather than the magnet"
        return "gain_or_calibration", (), f"{what}. Calibrate again"
    symbol = definition_of(quantity).symbol
    return "drift", (), f"{symbol} has {'risen' if up else 'fallen'}. Compare recordings from before and after"


def _told(
    name: ChangeName, what: str, change: _Noticed, along: tuple[str, ...], points: Sequence[Point], *, stands: bool
) -> TrendChange:
    stretch = change.stretch
    apart = (stretch.y - stretch.expected)[stretch.places >= change.first]
    newest = apart[np.isfinite(apart)][-10:]
    before = stretch.expected[stretch.places >= change.first][np.isfinite(apart)][-10:]
    moved = float(np.mean(newest)) * stretch.relative_to(float(np.mean(before))) if newest.size else float("nan")
    return TrendChange(
        name=name,
        what=what,
        quantities=(stretch.quantity, *along),
        relative=float(np.expm1(moved)) if stretch.logarithmic else moved,
        since=points[change.first].at,
        since_recording=points[change.first].recording,
        noticed=points[change.noticed].at,
        noticed_after_shots=sum(point.shots for point in points[change.first : change.noticed + 1]),
        stands=stands,
    )
