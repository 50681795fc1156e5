"""The client of a daemon: `Client`, and `AsyncClient` with the same methods for asyncio.

Example:
    >>> from platform_daemon.client import Client
    >>> with Client("http://127.0.0.1:8212") as lab:
    ...     job = lab.measure("jewel", shots=20, field_ut=490)
    ...     fits = job.wait(progress=True).fits()
"""

from .aio.client import AsyncClient
from .errors import (
    AccessDenied,
    ChecksumMismatch,
    ClientError,
    Conflict,
    ConnectionFailed,
    EventsDropped,
    InvalidRequest,
    JobCancelled,
    JobEnded,
    JobFailed,
    NotADaemon,
    NotFound,
    Refused,
    Unavailable,
    VersionMismatch,
    WaitTimeout,
)
from .sync.client import Client

__all__ = [
    "AccessDenied",
    "AsyncClient",
    "ChecksumMismatch",
    "Client",
    "ClientError",
    "Conflict",
    "ConnectionFailed",
    "EventsDropped",
    "InvalidRequest",
    "JobCancelled",
    "JobEnded",
    "JobFailed",
    "NotADaemon",
    "NotFound",
    "Refused",
    "Unavailable",
    "VersionMismatch",
    "WaitTimeout",
]
