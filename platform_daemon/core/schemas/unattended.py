"""A platform that is left alone: faults of owners that died, and what would keep a computer from it."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from pydantic import ConfigDict, Field, model_validator

from .base import Priority, Request, Schema, example
from .text import Name, OneLine, Text


class FaultUnlock(Schema):
    """Who clears the fault that an owner of the devices has left by its death, and why."""

    by: Annotated[str, Field(max_length=200), OneLine]
    """Name of the person."""
    reason: Text = ""
    """What was found."""


class QueueOrder(Request):
    """The order of jobs that wait for the platform: `order`, `priority`, or both."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"order": ["acquisition-20261121T101500-1a2b3c"]}, {"priority": {"ID": 10}}]}
    )

    order: Annotated[list[str], Field(max_length=1000)] = Field(default=[])
    """Ids of those that come first, the next one first, whatever their priority; all others follow as they were."""
    priority: Annotated[dict[str, Priority], Field(max_length=1000)] = Field(default={})
    """New priorities by id; what had been put in order by hand is no longer, if it is not in `order`."""

    @model_validator(mode="after")
    def _says_something(self) -> QueueOrder:
        if not self.order and not self.priority:
            raise ValueError("nothing is put in order: give `order`, `priority`, or both")
        return self


class FaultCleared(Schema):
    """What stood in the way of power, and who has cleared it."""

    model_config = ConfigDict(json_schema_extra=example("fault_cleared"))

    fault: str | None
    """The fault that was cleared; null: there was none."""
    by: str
    """Name of the person."""


class Verdict(StrEnum):
    """ok; warn: a person should know; fail: it must be corrected before unattended operation."""

    OK = "ok"
    WARN = "warn"
    FAIL = "fail"


class Finding(Schema):
    """One thing that was looked at."""

    check: str
    """What was looked at."""
    verdict: Verdict
    """The verdict."""
    found: str
    """What was found, with units."""
    remedy: str
    """What to do; empty if nothing."""


class Checkup(Schema):
    """What `doctor --json` writes: whether this computer may be left alone with a platform."""

    platform: str
    """Name of the platform."""
    findings: tuple[Finding, ...]
    """Everything that was looked at."""

    @property
    def fails(self) -> bool:
        """Something must not stay as it is."""
        return any(each.verdict is Verdict.FAIL for each in self.findings)


class MountRequest(Request):
    """A resonator was put into the clamping unit."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"resonator": "jewel", "by": "anna"}]})

    resonator: Annotated[str, Field(min_length=1, max_length=500)]
    """Its name, one of GET /resonators."""
    by: Name
    """Who has done it."""


class MountedResonator(Schema):
    """What is in the clamping unit, as far as anybody has said."""

    model_config = ConfigDict(json_schema_extra=example("mounted_resonator"))

    resonator: str | None
    """Its name; null: not reported."""
    by: str | None
    """Who has said so; null: it was measured last."""
    at: str | None
    """Since when, ISO 8601, UTC; null: not reported."""
    changed_by_platform: bool
    """The platform mounts resonators by itself; no person has to."""
