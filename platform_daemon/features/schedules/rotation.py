"""The work of one start: a schedule that names several resonators measures them in rotation."""

from __future__ import annotations

from drivers.errors import InputError

from .schema import AnyWorkRequest, ScheduleRequest


def works(request: ScheduleRequest) -> tuple[AnyWorkRequest, ...]:
    """The work with each resonator of the request once; the work itself if the request names none.

    Raises InputError for a kind of work that has no resonator of its own.
    """
    if request.resonators is None:
        return (request.work,)
    return tuple(_with(request.work, name) for name in dict.fromkeys(request.resonators))


def work_of(request: ScheduleRequest, starts_before: int) -> AnyWorkRequest:
    """The work of the start that comes after so many others.  Raises InputError as `works`."""
    names = request.resonators
    return request.work if names is None else _with(request.work, names[starts_before % len(names)])


def with_priority(work: AnyWorkRequest, priority: int) -> AnyWorkRequest:
    """The work with a priority in the queue; an analysis has none."""
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
