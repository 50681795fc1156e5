"""Requests of a diagnosis, and of the adoption of what it names."""

from __future__ import annotations

from typing import Annotated

from pydantic import ConfigDict, Field

from platform_daemon.core.schemas.base import Given, Request
from platform_daemon.core.schemas.recordings import Frames, Observable, RecordingId, StepName
from platform_daemon.core.schemas.requests import ModelName
from platform_daemon.core.schemas.text import Name, Text


class RecordingPart(Request):
    """Some frames of a recording."""

    recording: RecordingId
    """Id of the recording."""
    frames: Frames = None
    """Numbers of frames, from 0; null: all, of a procedure's recording those of `step`."""
    step: Given[StepName] = None
    """Step of a procedure's recording: its number, its name (tune, ramp, series, sweep), or all; missing: the last
    one."""


class DiagnosisRequest(Request):
    """A diagnosis of one specimen: what the declared model lacks."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"recordings": ["acquisition-20261121T101500-1a2b3c"]},
                {"recordings": ["a", {"recording": "b", "frames": [0, 1, 2]}], "base": "quiet"},
            ]
        }
    )

    recordings: Annotated[list[RecordingId | RecordingPart], Field(min_length=1, max_length=200)]
    """Ids, or objects with `frames`; several are diagnosed together."""
    variant: ModelName | None = None
    """The declared model; null: what the recordings say."""
    base: ModelName | None = None
    """A declared or adopted model to start from in its place."""
    observable: Observable | None = None
    """What was measured; null: what the recordings hold."""

    def parts(self) -> list[RecordingPart]:
        """Every recording with its frames."""
        return [p if isinstance(p, RecordingPart) else RecordingPart(recording=p) for p in self.recordings]


class AdoptionRequest(Request):
    """Adoption of what a diagnosis names: a named, versioned model for later fits."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"name": "quiet", "by": "DC"}]})

    name: Annotated[str, Field(max_length=64)]
    """Name of the model; one that exists gets a new version."""
    by: Name
    """Who adopts it."""
    effects: Annotated[list[str], Field(max_length=20)] = Field(default=[])
    """Ids of the effects to adopt; empty: all."""
    free: Annotated[list[str], Field(max_length=20)] = Field(default=[])
    """Ids of torque effects whose strength fits estimate again."""
    force: Text = ""
    """Why it is adopted although the data are not explained; is kept as evidence."""
