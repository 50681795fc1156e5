"""Alarms: what somebody should know, until it is over."""

from __future__ import annotations

from pydantic import ConfigDict

from .base import Request, Root, Schema, example
from .text import Name


class Alarm(Schema):
    """One thing that somebody should know.  It stands until it is over, and is shown for a while after that."""

    model_config = ConfigDict(json_schema_extra=example("alarm"))

    name: str
    """What it is about, as "disk" or "schedule:schedule-20261121T101500-1a2b3c"."""
    what: str
    """What is wrong, and what to do."""
    since: str
    """Since when, ISO 8601, UTC."""
    latest: str
    """When it was noticed last, ISO 8601, UTC."""
    times: int
    """How often it was noticed."""
    cleared: str | None
    """When it was over, ISO 8601, UTC; null: it stands."""
    acknowledged_by: str | None
    """Who has said that he knows; null: nobody."""
    acknowledged: str | None
    """When, ISO 8601, UTC; null: nobody has."""


class AlarmListing(Root[tuple[Alarm, ...]]):
    """Alarms, those that stand first, the oldest of them first."""

    model_config = ConfigDict(json_schema_extra=example("alarm", listed=True))


class Alarms(Root[tuple[Alarm, ...]]):
    """The file of the alarms."""


class Acknowledgement(Request):
    """Somebody knows of an alarm."""

    by: Name
    """Name of the person."""
