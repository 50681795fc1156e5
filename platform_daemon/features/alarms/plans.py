"""What the schedules themselves tell: that there are none, and which alarms are of one that is no more."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import datetime

from drivers.errors import PlatformError
from platform_daemon.core.state.errors import StorageError
from platform_daemon.features.schedules.schema import Schedule

from .board import AlarmBoard

Ask = Callable[[], Sequence[Schedule]]
"""All schedules.  Raises StorageError if their ledger cannot be used, PlatformError without an answer."""
_OF_ONE = ("schedule", "mount")  # alarms that end with their schedule


def look_at_schedules(board: AlarmBoard, ask: Ask) -> str:
    """Raise or clear what follows from them; in words, what is due next."""
    try:
        found = ask()
    except StorageError as error:
        board.notice("schedules", f"nothing starts by the calendar: {error}")
        return "nothing is due"
    except PlatformError:  # the alarm `hardware` reports it
        return "what is due next is not known"
    board.clear("schedules")
    _forget_removed(board, {each.id for each in found})
    _look_at_the_clock(board, found)
    _look_at_those_of_another_version(board, found)
    return _next(found)


def _forget_removed(board: AlarmBoard, there: set[str]) -> None:
    """Nothing of a schedule that is no more could ever end its alarms."""
    for name in board.standing():
        kind, _, of = name.partition(":")
        if kind in _OF_ONE and of not in there:
            board.clear(name)


def _look_at_the_clock(board: AlarmBoard, found: Sequence[Schedule]) -> None:
    """A clock that was ahead for a minute silences a schedule until then, long after its leap is forgotten."""
    ahead = [each for each in found if each.active and each.ahead_until is not None]
    if not ahead:
        board.clear("ledger-ahead")
        return
    names = ", ".join(f"{_name(each)} until {each.ahead_until}" for each in ahead)
    remedy = "set the clock right; if it is, `platform-daemon schedule resume ID` makes due again what is still to come"
    what = "the clock of this computer is behind what it has shown, and nothing that was due meanwhile starts again"
    board.notice("ledger-ahead", f"{what}: {names}. Remedy: {remedy}")


def _look_at_those_of_another_version(board: AlarmBoard, found: Sequence[Schedule]) -> None:
    """Schedules that start nothing although no person has suspended them."""
    left = [each for each in found if each.request is None]
    if not left:
        board.clear("schedules-unreadable")
        return
    names = ", ".join(each.id for each in left)
    board.notice("schedules-unreadable", f"nothing starts of {names}: {left[0].reason}")


def _next(found: Sequence[Schedule]) -> str:
    dues = [(datetime.fromisoformat(each.next_due), each) for each in found if each.active and each.next_due]
    if not dues:
        return f"nothing is due: {len(found)} schedules, none of which starts anything" if found else "nothing is due"
    due, first = min(dues, key=lambda each: each[0])
    return f"nothing is due until {due.isoformat(timespec='seconds')} ({_name(first)})"


def _name(schedule: Schedule) -> str:
    return schedule.id if schedule.request is None else schedule.request.name
