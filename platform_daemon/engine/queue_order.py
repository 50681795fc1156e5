"""The order of what waits, asked for by people."""

from __future__ import annotations

from collections.abc import Sequence

from drivers.errors import DeviceStateError, InputError

from .hardware_queue import HardwareQueue
from .jobs import AnyJob


def put_in_order(queue: HardwareQueue, identifiers: Sequence[str]) -> None:
    """These first, in this order; kept on disk.  Raises InputError for an id twice, DeviceStateError: it waits not."""
    if len(set(identifiers)) != len(identifiers):
        raise InputError("an id stands in it twice", where="order", remedy="name each job once")
    waiting = {job.identifier: job for job in queue.jobs()}
    for each in identifiers:
        if each not in waiting:
            remedy = "ask GET /platform for `queued`: only those can be put in order"
            raise DeviceStateError("this job does not wait for the platform", where=each, remedy=remedy)
    queue.order([waiting[each] for each in identifiers])
    for place, job in enumerate(queue.jobs()):
        _keep_place(job, place)


def _keep_place(job: AnyJob, place: int) -> None:
    job.place = place
    job.on_change(job)
