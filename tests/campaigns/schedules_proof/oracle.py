"""When a trigger is due: every minute of the time is looked at, with the offsets of the zone from zoneinfo.

A cron expression with a star in minute or hour goes by the clock on the wall, through doubled hours twice.  One that
names both is due once for every wall time: the first of two, and at the end of the leap if there is none.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from datetime import UTC, datetime
from itertools import pairwise
from typing import Any
from zoneinfo import ZoneInfo

import numpy as np
from numpy.typing import NDArray

MINUTE, DAY = 60, 86_400
Times = NDArray[np.int64]
_MARGIN_S = 2 * DAY


def due(trigger: dict[str, Any], start: float, end: float) -> list[float]:
    """Instants in [start, end], s since 1970; an interval is counted from `start`."""
    if "every_s" in trigger:
        count = math.floor((end - start) / trigger["every_s"])
        return [start + k * trigger["every_s"] for k in range(count + 1)]
    zone = ZoneInfo(trigger.get("time_zone", "UTC"))
    if "at" in trigger:
        found = {_instant(datetime.fromisoformat(text), zone) for text in trigger["at"]}
    else:
        found = {float(t) for t in _cron(trigger["cron"].split(), zone, start, end)}
    return sorted(t for t in found if start <= t <= end)


def _instant(local: datetime, zone: ZoneInfo) -> float:
    """The first minute whose wall time is this, or the first after a leap over it."""
    if local.tzinfo is not None:
        return local.timestamp()
    near = int(local.replace(tzinfo=UTC).timestamp())
    minutes = np.arange(near - _MARGIN_S, near + _MARGIN_S, MINUTE)
    wall = minutes + _offsets(minutes, zone)
    return float(minutes[np.argmax(wall >= near)])  # wall time first gets there, or leaps past it


def _offsets(minutes: Times, zone: ZoneInfo) -> Times:
    """Seconds east of UTC at every minute.  Changes are found by halving between days that differ."""
    out = np.empty_like(minutes)
    edges = [*range(0, len(minutes), DAY // MINUTE), len(minutes)]
    for first, after in pairwise(edges):
        for begin, stop in _steady(minutes, first, after, zone):
            out[begin:stop] = _offset(int(minutes[begin]), zone)
    return out


def _offset(at: int, zone: ZoneInfo) -> int:
    offset = datetime.fromtimestamp(at, zone).utcoffset()
    assert offset is not None
    return int(offset.total_seconds())


def _steady(minutes: Times, first: int, after: int, zone: ZoneInfo) -> Iterator[tuple[int, int]]:
    """Stretches of one offset in a day, which has one change at most."""
    begin = _offset(int(minutes[first]), zone)
    if _offset(int(minutes[after - 1]), zone) == begin:
        yield first, after
        return
    low, high = first, after - 1
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if _offset(int(minutes[middle]), zone) == begin else (low, middle)
    yield first, high
    yield high, after


def _cron(fields: list[str], zone: ZoneInfo, start: float, end: float) -> Times:
    first = int(start) // MINUTE * MINUTE - _MARGIN_S
    minutes = np.arange(first, int(end) + _MARGIN_S, MINUTE)
    wall = minutes + _offsets(minutes, zone)
    if "*" in fields[0][0] or "*" in fields[1][0]:
        return minutes[_matches(fields, wall)]
    asked = np.arange(wall[0] // DAY * DAY + DAY, wall[-1] // DAY * DAY - DAY, MINUTE)
    asked = asked[_matches(fields, asked)]
    furthest = np.maximum.accumulate(wall)  # a wall time is reached where it, or a later one, is shown first
    return minutes[np.searchsorted(furthest, asked)]


def _matches(fields: list[str], wall: Times) -> NDArray[np.bool_]:
    days = wall // DAY
    weekday = (days + 4) % 7  # 1970 began on a Thursday
    dates = days.astype("datetime64[D]")
    months = dates.astype("datetime64[M]")
    day = (dates - months).astype(np.int64) + 1
    month = months.astype(np.int64) % 12 + 1
    in_day = np.isin(day, _values(fields[2], 1, 31))
    on_weekday = np.isin(weekday, [v % 7 for v in _values(fields[4], 0, 7)])
    either = "*" not in fields[2][0] and "*" not in fields[4][0]
    date = (in_day | on_weekday) if either else (in_day & on_weekday)
    clock = np.isin(wall // MINUTE % 60, _values(fields[0], 0, 59)) & np.isin(
        wall // 3600 % 24, _values(fields[1], 0, 23)
    )
    return clock & date & np.isin(month, _values(fields[3], 1, 12))


def _values(field: str, least: int, most: int) -> list[int]:
    out: list[int] = []
    for part in field.split(","):
        span, _, step = part.partition("/")
        low, _, high = span.partition("-")
        begin = least if span == "*" else int(low)
        stop = most if span == "*" or (step and not high) else int(high or low)
        out += range(begin, stop + 1, int(step or 1))
    return out
