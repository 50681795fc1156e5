"""Jobs that waited when the daemon ended: they wait again, in their order, or are forgotten on purpose."""

from __future__ import annotations

from collections.abc import Callable

import structlog

from drivers.errors import InterlockError
from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.jobs.jobs import AnyJob
from platform_daemon.core.jobs.submit_options import ShuttingDown, WaitsNoMore
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.state.errors import StorageError

from .errors import foreseen

log = structlog.get_logger()


def take_up_queue(
    engine: Engine, take_up: Callable[[AnyJob], None], forget: Callable[[], str | None] = lambda: None
) -> None:
    """Queue again what an earlier run has left; what cannot be planned any more is failed with the reason.

    While a fault is latched, or the disk refuses, they stay as they are.

    take_up: queues a job again under its id, raises WaitsNoMore, PlatformError; forget: is called before each job and
    says why it is cancelled, None: it is not.
    """
    for job in engine.left_waiting():
        if job.state is not JobState.QUEUED:  # cancelled while those before it were planned
            continue
        if (why := forget()) is not None:
            job.warnings.append(why)
            engine.end_left(job, JobState.CANCELLED)
            continue
        try:
            take_up(job)
            log.info("job_taken_up", job=job.identifier)
        except WaitsNoMore:
            continue
        except ShuttingDown:  # they wait for the next start
            return
        except (InterlockError, StorageError) as error:  # they wait until a person has reset it, or for the next start
            log.warning("queue_waits", job=job.identifier, error=str(error))
            return
        except Exception as error:  # one unexpected error must not block the jobs after it
            log.error("job_not_taken_up", job=job.identifier, error=str(error))
            if not engine.end_left(job, JobState.FAILED, foreseen(error)):
                return
