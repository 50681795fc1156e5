"""What the port for stop answers: few types, which its process has read in milliseconds."""

from __future__ import annotations

from typing import Literal

from pydantic import ConfigDict

from .base import Schema, example


class Health(Schema):
    """The daemon is alive."""

    model_config = ConfigDict(json_schema_extra=example("health"))

    status: Literal["ok"]
    """ok."""
    version: str
    """Version of the daemon."""


class StopReport(Schema):
    """What was stopped."""

    model_config = ConfigDict(json_schema_extra=example("stop_report"))

    status: str
    """In words."""
    hung: bool = False
    """The process that owns the devices did not answer, and was ended first."""
