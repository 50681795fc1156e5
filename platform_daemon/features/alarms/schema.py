"""Schemas of the alarms."""

from __future__ import annotations

from pydantic import ConfigDict

from platform_daemon.core.schemas.base import ListPage, Request, Root, Schema, example
from platform_daemon.core.schemas.text import Name


class Alarm(Schema):
    """An alarm: a condition that a person should know of.  It is active until cleared, and listed for a while after."""

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
    """When it was cleared, ISO 8601, UTC; null: it is active."""
    acknowledged_by: str | None
    """Who has acknowledged it; null: no one."""
    acknowledged: str | None
    """When, ISO 8601, UTC; null: it has not been acknowledged."""


class AlarmListing(ListPage[Alarm]):
    """Alarms, active ones first, the oldest of them first."""

    model_config = ConfigDict(json_schema_extra=example("alarm", listed=True))


class Alarms(Root[tuple[Alarm, ...]]):
    """The file of the alarms."""


class Acknowledgement(Request):
    """Acknowledgement of an alarm by a person."""

    by: Name
    """Name of the person."""
