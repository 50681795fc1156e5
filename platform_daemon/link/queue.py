"""Jobs that waited when the daemon ended: they wait again, in their order, or are forgotten on purpose."""

from __future__ import annotations

from typing import Protocol

import structlog

from drivers.errors import InterlockError, PlatformError
from platform_daemon.engine import AnyJob, Engine, ShuttingDown
from platform_daemon.schemas import JobState

log = structlog.get_logger()


class TakesUp(Protocol):
    """Who makes the work of a job anew."""

    def take_up(self, job: AnyJob) -> None:
        """Queue it again under its id.  Raises PlatformError."""


def take_up_queue(engine: Engine, owner: TakesUp, *, forget: bool) -> None:
    """Queue again what an earlier run has left; what cannot be planned any more is failed with the reason.

    While a fault stands they stay as they are.

    forget: cancel all of it.
    """
    for job in engine.left_waiting():
        if forget:
            job.warnings.append("forgotten when the daemon was started (--forget-queue)")
            engine.end_left(job, JobState.CANCELLED)
            continue
        if job.state is not JobState.QUEUED:  # cancelled while those before it were planned
            continue
        try:
            owner.take_up(job)
            log.info("job_taken_up", job=job.identifier)
        except ShuttingDown:  # they wait for the next start
            return
        except InterlockError as error:  # a fault stands: they are taken up when a person has reset it
            log.warning("queue_waits", job=job.identifier, error=str(error))
            return
        except PlatformError as error:
            log.error("job_not_taken_up", job=job.identifier, error=str(error))
            engine.end_left(job, JobState.FAILED, error)
