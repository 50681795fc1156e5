"""How it came to be asked for a job, and why none is made."""

from __future__ import annotations

from dataclasses import dataclass

from drivers.errors import DeviceStateError

from .jobs import AnyJob


class ShuttingDown(DeviceStateError):
    """The daemon takes no work any more."""

    title = "Shutting down"


class WaitsNoMore(DeviceStateError):
    """A job of an earlier run has ended while it was planned."""

    title = "Waits no more"


@dataclass(frozen=True)
class Asked:
    """identifier: that the job will have, None: a new one; again: the job of an earlier run whose id and time it has.

    waits: `again` waited when the daemon ended, and must do so still; stops: how often everything had been stopped
    when somebody asked, None: as often as now.
    """

    identifier: str | None = None
    again: AnyJob | None = None
    waits: bool = False
    stops: int | None = None


AS_NOW = Asked()
"""A new one, as everything is."""
