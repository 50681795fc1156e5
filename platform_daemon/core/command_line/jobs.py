"""A job on the command line: submitted to the engine of this process, and watched to its end."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .progress import progress

if TYPE_CHECKING:
    from platform_daemon.core.hardware.engine import Engine
    from platform_daemon.core.jobs.jobs import Job, RequestT, ResultT, Work


def run_job(engine: Engine, work: Work[RequestT, ResultT]) -> Job[RequestT, ResultT]:
    """The job of this work at its end, with its progress shown on stderr.  Raises the error of the job."""
    job = engine.submit(work)
    with progress() as display:
        display.watch(job)
    if job.error is not None:
        raise job.error
    return job
