"""Schedules by their names."""

from __future__ import annotations

from typing import TYPE_CHECKING

from drivers.errors import InputError

if TYPE_CHECKING:
    from .contract import ScheduleService


def named_id(schedules: ScheduleService, given: str) -> str:
    """The id of the schedule of this name or id, and what was given if none has it: one that was removed has its
    ledger, and is not listed.

    Raises InputError for a name that several have.
    """
    known = schedules.list()
    named = [each.id for each in known if each.request is not None and each.request.name == given]
    if any(each.id == given for each in known) or not named:
        return given
    if len(named) > 1:
        why, remedy = f"{len(named)} schedules have it", f"give one of the ids {', '.join(named)}"
        raise InputError("the name is not unique", where=given, why=why, remedy=remedy)
    return named[0]
