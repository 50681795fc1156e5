"""Jobs that waited when the daemon ended: they wait again, in their order, or are forgotten on purpose."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import structlog

from drivers.errors import InterlockError
from platform_daemon.engine import AnyJob, Engine, ShuttingDown, WaitsNoMore
from platform_daemon.schemas import JobState
from platform_daemon.store import StorageError

from .errors import foreseen

log = structlog.get_logger()


class TakesUp(Protocol):
    """Who makes the work of a job anew."""

    def take_up(self, job: AnyJob) -> None:
        """Queue it again under its id.  Raises WaitsNoMore, PlatformError."""


def take_up_queue(engine: Engine, owner: TakesUp, forget: Callable[[], str | None] = lambda: None) -> None:
    """Queue again what an earlier run has left; what cannot be planned any more is failed with the reason.

    While a fault stands, or the disk refuses, they stay as they are.

    forget: asked before each: why it is cancelled, None: it is not.
    """
    for job in engine.left_waiting():
        if job.state is not JobState.QUEUED:  # cancelled while those before it were planned
            continue
        if (why := forget()) is not None:
            job.warnings.append(why)
            engine.end_left(job, JobState.CANCELLED)
            continue
        try:
            owner.take_up(job)
            log.info("job_taken_up", job=job.identifier)
        except WaitsNoMore:
            continue
        except ShuttingDown:  # they wait for the next start
            return
        except (InterlockError, StorageError) as error:  # they wait until a person has reset it, or for the next start
            log.warning("queue_waits", job=job.identifier, error=str(error))
            return
        except Exception as error:  # those after it must not wait for one that nobody has thought of
            log.error("job_not_taken_up", job=job.identifier, error=str(error))
            if not engine.end_left(job, JobState.FAILED, foreseen(error)):
                return
