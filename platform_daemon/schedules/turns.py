"""What a start is: with which of several resonators in turn, and with which priority."""

from __future__ import annotations

from drivers.errors import InputError
from platform_daemon.schemas import AnyWorkRequest, ScheduleRequest


def works(request: ScheduleRequest) -> tuple[AnyWorkRequest, ...]:
    """Its work with each of its resonators, each of these once; the work as it is if it names none.

    Raises InputError for a work that has no resonator to change.
    """
    if request.resonators is None:
        return (request.work,)
    return tuple(_with(request.work, name) for name in dict.fromkeys(request.resonators))


def work_of(request: ScheduleRequest, turn: int) -> AnyWorkRequest:
    """The work of the start after so many.  Raises InputError as `works`."""
    names = request.resonators
    return request.work if names is None else _with(request.work, names[turn % len(names)])


def with_priority(work: AnyWorkRequest, priority: int) -> AnyWorkRequest:
    """The work as it is queued; one that leaves the platform alone has none."""
    if work.kind == "fit" or work.kind == "diagnosis":
        return work
    request = work.request.model_copy(update={"priority": priority})
    return work.model_copy(update={"request": request})


def _with(work: AnyWorkRequest, resonator: str) -> AnyWorkRequest:
    if work.kind == "acquisition":
        return work.model_copy(update={"request": work.request.model_copy(update={"resonator": resonator})})
    if work.kind == "procedure":
        acquisition = work.request.acquisition.model_copy(update={"resonator": resonator})
        return work.model_copy(update={"request": work.request.model_copy(update={"acquisition": acquisition})})
    remedy = "leave `resonators` out, or give a series or a procedure"
    raise InputError("this work is not done with a resonator of its own", where="resonators", remedy=remedy)
