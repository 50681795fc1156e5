"""What calibrates a resonator as a sensor."""

from __future__ import annotations

from typing import Annotated

from pydantic import ConfigDict, Field, model_validator

from platform_daemon.core.schemas.base import Given, Request

_READINGS = "time,pressure [mbar],u [mbar]\n2026-11-21T18:00:00Z,1003.2,0.1\n2026-11-21T18:01:00Z,1003.3,0.1\n"


class MeasurandRequest(Request):
    """Calibrate a resonator as a sensor: by `schedule`, or by `recordings`."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"specimen": "sensor", "schedule": "nightly", "reference": _READINGS}]}
    )

    specimen: Annotated[str, Field(min_length=1, max_length=200)]
    """Resonator, as an acquisition names it; its file says by `measurand` what it is a sensor for."""
    schedule: Given[Annotated[str, Field(min_length=1, max_length=100)]] = None
    """Name or id of a schedule: all of its recordings that are of this resonator."""
    since: Given[Annotated[str, Field(max_length=40)]] = None
    """Of the schedule only what was started from then on, ISO 8601."""
    until: Given[Annotated[str, Field(max_length=40)]] = None
    """Of the schedule only what was started until then, ISO 8601; a date: until its end."""
    recordings: Given[Annotated[list[str], Field(min_length=1, max_length=1000)]] = None
    """Ids of recordings that were made while the reference was read."""
    reference: Given[Annotated[str, Field(min_length=1, max_length=900_000)]] = None
    """Readings of the reference as CSV: a heading `time,NAME [UNIT]` or `time,NAME [UNIT],u [UNIT]`, times in ISO 8601
    with their zone.  Missing: the thermometer of the platform, for a measurand `temperature` in degC."""

    @model_validator(mode="after")
    def _one_source(self) -> MeasurandRequest:
        if (self.schedule is None) == (self.recordings is None):
            raise ValueError("give `schedule`, or `recordings`")
        if self.schedule is None and (self.since, self.until) != (None, None):
            raise ValueError("`since` and `until` choose recordings of a `schedule`")
        return self
