"""Due instants of a trigger, as seconds since 1970 (POSIX, UTC: leap seconds are not counted).

A local time that daylight saving leaves out is due at the first valid moment after it; one that comes twice is due
once, the first time.  Cron expressions with a star in minute or hour go by the clock on the wall through both, which is
Debian's rule.  cronsim finds local times; it is given none with a zone, since it leaves some out where daylight saving
is half an hour (Lord Howe, cronsim 2.8).
"""

from __future__ import annotations

import hashlib
import itertools
import math
from collections.abc import Iterator
from contextlib import suppress
from datetime import UTC, datetime, timedelta
from zoneinfo import ZoneInfo

from cronsim import CronSim, CronSimError

from drivers.errors import InputError

from .schema import ScheduleRequest, TriggerRequest

_CRON = "minute 0-59, hour 0-23, day 1-31, month 1-12, weekday 0-7, as in '0 22 * * 1-5', and a day that its month has"
_BACK = timedelta(hours=26)  # cron begins so long before: no rule about a changed clock begins in its middle
_END = datetime(9998, 1, 1, tzinfo=UTC).timestamp()  # no instant is later: with jitter and grace it must have a date


class Calendar:
    """When a schedule is due.  created: when it was requested, s.  Raises InputError."""

    def __init__(self, request: ScheduleRequest, created: float) -> None:
        self._trigger = request.trigger
        self._zone = _zone(request.trigger.time_zone)
        self.start = created if request.start is None else self._moment(request.start, "start")
        self.until = math.inf if request.until is None else self._moment(request.until, "until")
        if self.until < max(self.start, created):
            raise InputError("the schedule ends before it starts", where="until", remedy="choose a later end")
        given = [k for k in ("every_s", "cron", "at") if getattr(request.trigger, k) is not None]
        if len(given) != 1:
            why = "none of them is given" if not given else f"given are {' and '.join(given)}"
            remedy = "give every_s: 3600, cron: '0 22 * * *' or at: ['2027-01-01T08:00']"
            raise InputError("a trigger has one of every_s, cron and at", where="trigger", why=why, remedy=remedy)
        if next(self.after(self.start, inclusive=True), None) is None:
            remedy = "preview another expression; dates have to lie between start and until"
            raise InputError("the schedule is never due", where=f"trigger.{given[0]}", remedy=remedy)

    def after(self, moment: float, *, inclusive: bool = False) -> Iterator[float]:
        """All due instants after `moment` (inclusive: and at it), in order."""
        for due in self._all(max(moment, self.start)):
            if due > min(self.until, _END):
                return
            if due >= self.start and (due > moment or (inclusive and due == moment)):
                yield due

    def shown(self, due: float) -> str:
        """An instant in the zone of the trigger, ISO 8601."""
        return datetime.fromtimestamp(due, self._zone).isoformat()

    def shortest_gap_s(self) -> float:
        """Between two instants, of the first 200; inf: there is one only."""
        first = itertools.islice(self.after(self.start, inclusive=True), 200)
        return min((b - a for a, b in itertools.pairwise(first)), default=math.inf)

    def _all(self, near: float) -> Iterator[float]:
        """Instants in order, from at or before `near` on."""
        trigger = self._trigger
        if trigger.every_s is not None:
            number = max(0, math.floor((near - self.start) / trigger.every_s) - 1)
            return (self.start + k * trigger.every_s for k in itertools.count(number))
        if trigger.at is not None:
            return iter(sorted({self._moment(text, "trigger.at") for text in trigger.at}))
        return self._cron(trigger, near)

    def _cron(self, trigger: TriggerRequest, near: float) -> Iterator[float]:
        assert trigger.cron is not None
        if len(trigger.cron.split()) != 5:
            why = f"it is {trigger.cron!r}"
            raise InputError("a cron expression has five fields", where="trigger.cron", why=why, remedy=_CRON)
        try:
            CronSim(trigger.cron, datetime(2000, 1, 1))
            near_utc = datetime.fromtimestamp(near, UTC)
        except CronSimError as error:
            raise InputError("no cron expression", where="trigger.cron", why=str(error), remedy=_CRON) from None
        except (OverflowError, ValueError, OSError) as error:
            remedy = "choose a start between 1970 and 9999"
            raise InputError("a time outside the calendar", where="start", why=str(error), remedy=remedy) from None
        wall = any(field.startswith("*") for field in trigger.cron.split()[:2])
        found = self._by_the_wall(trigger.cron, near) if wall else self._named(trigger.cron, near_utc)
        last = -math.inf
        with suppress(OverflowError, ValueError):  # the calendar ends with the year 9999
            for due in found:
                if due > last:  # each instant once
                    last = due
                    yield due

    def _named(self, cron: str, near: datetime) -> Iterator[float]:
        """Hour and minute are named: every wall time once, though the clock leaps over it, or shows it twice."""
        for local in CronSim(cron, near.astimezone(self._zone).replace(tzinfo=None) - _BACK):
            yield _first_valid(local, self._zone).timestamp()

    def _by_the_wall(self, cron: str, near: float) -> Iterator[float]:
        """Whenever a clock on the wall shows it; stretch by stretch in which that keeps one distance from UTC."""
        while True:
            offset, change = self._stretch(near)
            begin = datetime.fromtimestamp(near, UTC).replace(tzinfo=None) + offset
            for local in CronSim(cron, begin - timedelta(minutes=1)):
                due = (local - offset).replace(tzinfo=UTC).timestamp()
                if due >= change:
                    break
                if due >= near:
                    yield due
            else:
                return
            near = change

    def _stretch(self, near: float) -> tuple[timedelta, float]:
        """How far the wall is from UTC, and when it may be another distance: within 400 days."""
        offset, day = self._offset(near), 86_400
        same, other = near, near + day
        while self._offset(other) == offset:
            same, other = other, other + day
            if other > near + 400 * day:
                return offset, same
        low, high = math.floor(same), math.ceil(other)
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if self._offset(middle) == offset else (low, middle)
        return offset, float(high)

    def _offset(self, at: float) -> timedelta:
        return datetime.fromtimestamp(at, self._zone).utcoffset() or timedelta(0)

    def _moment(self, text: str, where: str) -> float:
        try:
            local = datetime.fromisoformat(text)
            if local.tzinfo is None:
                local = _first_valid(local, self._zone)
            return local.timestamp()
        except (ValueError, OverflowError) as error:
            remedy = "write it like 2026-11-23T02:30"
            raise InputError(f"{text!r} is no time", where=where, why=str(error), remedy=remedy) from None


def _first_valid(local: datetime, zone: ZoneInfo) -> datetime:
    """The local time in its zone; where the clock leaps over it, the moment of the leap."""
    there = local.replace(tzinfo=zone)  # fold=0: of two the first
    if there.astimezone(UTC).astimezone(zone).replace(tzinfo=None) == local:
        return there
    low, high = (local - timedelta(days=1)).replace(tzinfo=zone), (local + timedelta(days=1)).replace(tzinfo=zone)
    below, above = int(low.timestamp()), int(high.timestamp())
    while above - below > 1:  # local time does not fall but at the leap: bisect for the first moment past `local`
        middle = (below + above) // 2
        past = datetime.fromtimestamp(middle, zone).replace(tzinfo=None) >= local
        below, above = (below, middle) if past else (middle, above)
    return datetime.fromtimestamp(above, zone)


def cron_in_words(trigger: TriggerRequest) -> str | None:
    """A cron expression in words, as cronsim says it: "At 22:00 on Monday through Friday"; None: the trigger has none.

    The trigger is one that a Calendar has taken: an expression that is none raises CronSimError.
    """
    return None if trigger.cron is None else CronSim(trigger.cron, datetime(2000, 1, 1)).explain()


def jitter_s(identifier: str, due: float, most_s: float) -> float:
    """How long a start is put off, s: evenly in [0, most_s), always the same for the same instant."""
    digest = hashlib.sha256(f"{identifier} {due!r}".encode()).digest()
    return most_s * int.from_bytes(digest[:7]) / 2**56


def _zone(name: str) -> ZoneInfo:
    remedy = "use an IANA name like Europe/Berlin"
    if name.startswith("right/"):
        why = "its clock counts leap seconds, and that of this computer does not"
        raise InputError(f"no time zone {name!r}", where="trigger.time_zone", why=why, remedy=remedy)
    try:
        return ZoneInfo(name)
    except (OSError, ValueError, KeyError):  # ZoneInfoNotFoundError is a KeyError
        raise InputError(f"no time zone {name!r}", where="trigger.time_zone", remedy=remedy) from None
