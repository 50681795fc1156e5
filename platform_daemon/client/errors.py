"""The exceptions of the client, all below PlatformError, with what happened, where, why and what to do about it.

PlatformError
├── InputError             an argument that no request can be made of; nothing was sent
└── ClientError
    ├── ConnectionFailed   nothing answers at the address, or no longer
    ├── NotADaemon         something answers, but not as a platform daemon does
    ├── VersionMismatch    the daemon is of another version than this client
    ├── Refused            the daemon refuses a request; `status`, `title` and `type` are those of its problem details
    │   ├── AccessDenied   401, 403: the token is missing, unknown, or of another role
    │   ├── NotFound       404: there is nothing of that id or name
    │   ├── Conflict       409, 423: it does not fit the state that the platform is in
    │   ├── InvalidRequest other 4xx: the request is wrong; nothing has moved
    │   └── Unavailable    429, 5xx: a device failed, the disk is full, or the daemon has too much work
    ├── JobEnded           a job that was waited for has ended without a result
    │   ├── JobFailed      it has failed, for the reason that it names
    │   └── JobCancelled   it was cancelled
    ├── WaitTimeout        a job has not ended within the time that was given
    ├── EventsDropped      events were missed
    └── ChecksumMismatch   a downloaded file is not the one that the daemon has
"""

from __future__ import annotations

from drivers.errors import PlatformError
from platform_daemon.core.schemas.problems import Problem


class ClientError(PlatformError):
    """What keeps the client from doing what was requested."""


class ConnectionFailed(ClientError):
    """Nothing answers at the address, or no longer."""

    title = "Connection failed"


class NotADaemon(ClientError):
    """Something answers at the address, but not as a platform daemon does."""

    title = "Not a platform daemon"


class VersionMismatch(ClientError):
    """The daemon is of another version than this client."""

    title = "Version mismatch"


class Refused(ClientError):
    """The daemon refuses a request, or a job has failed.

    Attributes:
        problem: its problem details; status, type: of these.
    """

    title = "Refused"

    def __init__(self, problem: Problem) -> None:
        where, remedy = problem.where or "", problem.remedy or ""
        why = (problem.detail or "").removeprefix(f"{where}: ").removesuffix(f"Remedy: {remedy}.").strip()
        super().__init__(problem.title, where=where, why=why, remedy=remedy)
        self.title, self.problem = problem.title, problem
        self.status, self.type = problem.status, problem.type


class AccessDenied(Refused):
    """The token is missing, unknown, or of another role."""


class NotFound(Refused):
    """There is nothing of that id or name."""


class Conflict(Refused):
    """The request does not fit the state that the platform is in."""


class InvalidRequest(Refused):
    """The request is wrong, or cannot be carried out; nothing has moved."""


class Unavailable(Refused):
    """A device failed, the disk is full, or the daemon has too much work."""


class JobEnded(ClientError):
    """A job that was waited for has ended without a result.

    Attributes:
        job: its id.
    """

    title = "Job ended"

    def __init__(self, job: str, what: str, *, why: str = "", remedy: str = "") -> None:
        super().__init__(what, where=job, why=why, remedy=remedy)
        self.job = job


class JobFailed(JobEnded):
    """A job has failed, for the reason that it names."""

    title = "Job failed"


class JobCancelled(JobEnded):
    """A job that was waited for was cancelled."""

    title = "Job cancelled"


class WaitTimeout(ClientError):
    """A job has not ended within the time that was given; it goes on."""

    title = "Not ended in time"


class EventsDropped(ClientError):
    """Events were missed: the listener was too slow, or away for too long.

    Attributes:
        count: number of missed events, None: unknown; last: number of the last event before the gap that is not missed.
    """

    title = "Events dropped"

    def __init__(self, count: int | None, last: int) -> None:
        how_many = "an unknown number of" if count is None else str(count)
        super().__init__(
            f"{how_many} events were missed",
            where="events",
            why="the daemon sends no more than 1000 events behind the newest one, and keeps the last 100 000",
            remedy=f"look at the jobs for what became of them, then listen again with after={last}",
        )
        self.count, self.last = count, last


class ChecksumMismatch(ClientError):
    """A downloaded file is not the one that the daemon has."""

    title = "Checksum mismatch"


def refused(problem: Problem) -> Refused:
    """The exception of the problem details of an answer."""
    kinds: dict[int, type[Refused]] = {401: AccessDenied, 403: AccessDenied, 404: NotFound, 409: Conflict}
    kinds |= {423: Conflict, 429: Unavailable}
    other = InvalidRequest if problem.status < 500 else Unavailable
    return kinds.get(problem.status, other)(problem)
