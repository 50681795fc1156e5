"""Options of the submission of a job, and the errors that refuse it."""

from __future__ import annotations

from dataclasses import dataclass

from drivers.errors import DeviceStateError

from .jobs import AnyJob


class ShuttingDown(DeviceStateError):
    """The daemon is shutting down and accepts no more work."""

    title = "Shutting down"
    http_status = 503


class WaitsNoMore(DeviceStateError):
    """A waiting job of an earlier run was cancelled while its work was planned."""

    title = "Waits no more"


@dataclass(frozen=True)
class SubmitOptions:
    """How a job is submitted.

    identifier: id of the job, None: a new one; again: the job of an earlier run whose id and time the new job takes.

    waits: `again` waited when the daemon ended, and must still wait; stops: the number of stops of everything at the
    time of the request, None: the number now.  A job that was requested before a stop is not made after it.
    """

    identifier: str | None = None
    again: AnyJob | None = None
    waits: bool = False
    stops: int | None = None


SUBMIT_NOW = SubmitOptions()
"""A new job, requested now."""
