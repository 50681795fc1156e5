"""The self-test as a job of its own."""

from __future__ import annotations

from pydantic import ConfigDict

from .base import QueuedRequest
from .text import Line, Text


class SelfTestRequest(QueuedRequest):
    """A self-test now: a low tone per coil, as the table `[self_test]` of the platform file says."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"operator": "DC", "comment": "after new cables"}]})

    operator: Line = ""
    """Who asks, one line, for the record."""
    comment: Text = ""
    """Why, for the record."""
