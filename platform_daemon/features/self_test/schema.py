"""The self-test: its request as a job of its own, and its result."""

from __future__ import annotations

from pydantic import ConfigDict

from platform_daemon.core.schemas.base import Absent, QueuedRequest, Schema, example
from platform_daemon.core.schemas.text import Line, Text


class SelfTestRequest(QueuedRequest):
    """A self-test now: a weak tone per coil, as the table `[self_test]` of the platform file says."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"operator": "DC", "comment": "after new cables"}]})

    operator: Line = ""
    """Who asks, one line, for the record."""
    comment: Text = ""
    """Why, for the record."""


class SelfTestReport(Schema):
    """What the self-test has measured of every coil through the open receive contacts."""

    model_config = ConfigDict(json_schema_extra=example("self_test_report"))

    frequency_hz: float
    """Frequency of its tones, Hz."""
    gain: dict[str, float]
    """Gain by coil, relative to what is expected."""
    isolation_db: dict[str, float]
    """Isolation of the switch by coil, dB."""
    date: Absent[str] = None
    """When it was made, ISO 8601; missing: by an earlier version."""
