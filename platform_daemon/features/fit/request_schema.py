"""Requests on stored data and on plans: fits, diagnoses, adopted models, predictions, defects."""

from __future__ import annotations

from typing import Annotated

from pydantic import ConfigDict, Field

from platform_daemon.core.schemas.base import Finite, Given, NamedWindow, Positive, Request, Window
from platform_daemon.core.schemas.parameters import PAPER_NOISE_AM2_PER_S
from platform_daemon.core.schemas.recordings import Frames, RecordingId, StepName, Terms
from platform_daemon.core.schemas.requests import ModelName, SequencePatch


class RecordingFitRequest(Request):
    """A fit of a stored recording."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"recording": "acquisition-20261121T101500-1a2b3c", "window": "n50"}]}
    )

    recording: RecordingId
    """Id of the recording."""
    variant: ModelName | None = None
    """Model: thread, jewel or another declared one, or an adopted one; null: what the recording says."""
    terms: Terms = Field(default=[])
    """Further torque terms, as quadratic_drag."""
    window: Window = "d30"
    """Evaluation window: n50, d30, or seconds."""
    fixed: dict[str, Finite] = Field(default={})
    """Parameters that are held, by public name, SI."""
    hints: dict[str, Finite] = Field(default={})
    """Losses that are held only in frames whose window cannot tell them apart, by public name, SI."""
    frames: Frames = None
    """Numbers of frames, from 0; null: all, of a procedure's recording those of `step`."""
    step: Given[StepName] = None
    """Step of a procedure's recording: its number, its name (tune, ramp, series, sweep), or all; missing: the last
    one."""


class PredictionRequest(Request):
    """A planned measurement, whose smallest standard deviations are to be predicted."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"resonator": "jewel", "windows": ["n50", 1.0], "phi_max_rad": 0.7}]},
    )

    resonator: ModelName
    """Name of a resonator, one of GET /resonators."""
    windows: Annotated[
        list[NamedWindow | Annotated[float, Field(gt=0, le=100)]], Field(min_length=1, max_length=20)
    ] = Field(default=["n50", "d30"])
    """Evaluation windows: n50, d30, or seconds."""
    phi_max_rad: Annotated[float, Field(gt=0, lt=1.5)] | None = None
    """Largest deflection, rad; null: the paper's, or, with a manufacturing error, what the drive makes."""
    noise_am2_per_s: Annotated[tuple[Positive, ...], Field(strict=False, min_length=3, max_length=3)] = (
        PAPER_NOISE_AM2_PER_S
    )
    """Standard deviation of the noise of x, y, z per sample, A m^2/s."""
    sampling_rate_hz: Positive = 125e6 / 2048
    """Sampling rate, Hz."""
    fixed: Annotated[list[str], Field(max_length=9)] = Field(default=[])
    """Public names of parameters that are held."""
    variant: ModelName | None = None
    """Model that is to be fitted, declared or adopted; null: the resonator's."""
    terms: Terms = Field(default=[])
    """Further torque terms, as quadratic_drag."""
    estimate_adopted: bool = False
    """Estimate what an adopted model holds: strengths of torques, not their time constants and the like; or a
    manufacturing error, with the distance of the magnets and the damping of the side modes."""
    expected: dict[str, Finite] = Field(default={})
    """Expected values that the resonator's file does not hold, by public name, SI."""
    sequence: SequencePatch = Field(default_factory=SequencePatch)
    """Keys of the drive that differ from the resonator's preset: of an adopted model with a manufacturing error, whose
    motion begins with the drive."""
