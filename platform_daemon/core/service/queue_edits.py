"""What people may change of jobs that wait, and of series that were cut off."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

from drivers.errors import DeviceStateError, InputError
from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.jobs.hardware_queue import in_turn
from platform_daemon.core.jobs.jobs import AnyJob, Work
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.state.errors import StorageError


def put_in_order(engine: Engine, identifiers: Sequence[str], priorities: Mapping[str, int]) -> None:
    """New priorities for some, and these first, in this order, whatever their priority; kept on disk.

    Who gives a priority takes that job out of an order that was given before.  Raises InputError for an id twice,
    DeviceStateError: one of them waits not, StorageError: all is as before.
    """
    if len(set(identifiers)) != len(identifiers):
        raise InputError("an id stands in it twice", where="order", remedy="name each job once")

    def change(jobs: Sequence[AnyJob]) -> None:
        waiting = {job.identifier: job for job in jobs}
        for each in (*identifiers, *priorities):
            if each not in waiting:
                remedy = "ask GET /platform for `queued`: only those can be put in order"
                raise DeviceStateError("this job does not wait for the platform", where=each, remedy=remedy)
        before = {each: (job.request, job.place) for each, job in waiting.items()}
        for each, priority in priorities.items():
            job = waiting[each]
            job.request, job.place = job.request.model_copy(update={"priority": priority}), None
        named = [waiting[each] for each in identifiers]
        others = [job for job in in_turn(jobs) if job.place is not None and job not in named]
        for place, job in enumerate([*named, *others]):
            job.place = place
        _keep_changed(engine, waiting, before)

    engine.queue.change(change)


def _keep_changed(engine: Engine, waiting: Mapping[str, AnyJob], before: Mapping[str, tuple[Any, int | None]]) -> None:
    """Raises StorageError: all of them are as before, on the disk too as far as it lets us."""
    changed = [job for each, job in waiting.items() if (job.request, job.place) != before[each]]
    try:
        for job in changed:
            engine.keep(job)
    except StorageError:
        for job in changed:
            job.request, job.place = before[job.identifier]
        with suppress(StorageError):
            for job in changed:
                engine.keep(job)
        raise


def edit_waiting(engine: Engine, job: AnyJob, work: Callable[[], Work[Any, Any]]) -> AnyJob:
    """Another work in place of that of a job which has not begun; on disk before it holds.

    It keeps its id and its place, unless its priority is another one.  work: makes it, checked.

    Raises DeviceStateError if it has begun or is resumed, StorageError, and what `work` raises.
    """
    refused = DeviceStateError(
        "only what has not begun can be changed",
        where=job.identifier,
        remedy="cancel it, or wait for its end, and ask for a new one",
    )
    goes_on = getattr(job.result, "recording", None) is not None
    if job.state is not JobState.QUEUED or job.within is not None or goes_on:
        raise refused
    other = work()

    def change() -> Callable[[AnyJob], None]:
        before = job.request, job.total, job.unit, job.result, job.place
        place = job.place if other.request.priority == job.priority else None
        job.request, job.total, job.unit, job.result, job.place = (
            *(other.request, other.total, other.unit, other.no_result),
            place,
        )
        try:
            engine.keep(job)
        except StorageError:
            job.request, job.total, job.unit, job.result, job.place = before
            raise
        return other

    if not engine.queue.exchange(job, change):
        raise refused
    return job


def check_resumable(job: AnyJob) -> None:
    """Raises DeviceStateError unless shots are missing of a series that was cut off."""
    if job.within is not None:
        what, why = "only a series of its own can be resumed", "this is a step"
    elif job.state is JobState.DONE:
        what, why = "nothing is missing", "all its shots are there"
    else:
        return
    raise DeviceStateError(what, where=job.identifier, why=why, remedy="ask for what is missing as a new job")
