"""What is asked of stored data and of plans: fits, diagnoses, adopted models, predictions."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field
from typing_extensions import TypeAliasType

from .base import Finite, NamedWindow, Positive, Request, Window
from .parameters import PAPER_NOISE_AM2_PER_S
from .requests import ModelName

RecordingId = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$", max_length=200)]
Frames = Annotated[list[Annotated[int, Field(ge=0)]], Field(min_length=1, max_length=100_000)] | None
Terms = Annotated[list[ModelName], Field(max_length=8)]
Observable = TypeAliasType("Observable", Literal["dmdt", "angle"])


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
    """Numbers of frames, from 0; null: all."""


class RecordingPart(Request):
    """Some frames of a recording."""

    recording: RecordingId
    """Id of the recording."""
    frames: Frames = None
    """Numbers of frames, from 0; null: all."""


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
    by: Annotated[str, Field(min_length=1, max_length=200)]
    """Who adopts it."""
    effects: Annotated[list[str], Field(max_length=20)] = Field(default=[])
    """Ids of the effects to adopt; empty: all."""
    free: Annotated[list[str], Field(max_length=20)] = Field(default=[])
    """Ids of torque effects whose strength fits estimate anew."""
    force: Annotated[str, Field(max_length=2000)] = ""
    """Why it is adopted although the data are not explained; is kept as evidence."""


class RetirementRequest(Request):
    """A version of an adopted model is taken out of use."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"reason": "thread replaced", "by": "DC"}]})

    reason: Annotated[str, Field(min_length=1, max_length=2000)]
    """Why; is kept."""
    by: Annotated[str, Field(max_length=200)] = ""
    """Who; is kept."""


class PredictionRequest(Request):
    """A planned measurement, of which the smallest standard deviations are asked."""

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
    """Largest deflection, rad; null: the paper's."""
    noise_am2_per_s: Annotated[tuple[Positive, ...], Field(strict=False, min_length=3, max_length=3)] = (
        PAPER_NOISE_AM2_PER_S
    )
    """Standard deviation of the noise of x, y, z per sample, A m^2/s."""
    sampling_rate_hz: Positive = 125e6 / 2048
    """Sampling rate, Hz."""
    fixed: Annotated[list[str], Field(max_length=9)] = Field(default=[])
    """Public names of parameters that are held."""
    variant: ModelName | None = None
    """Model that is to be fitted; null: the resonator's."""
    terms: Terms = Field(default=[])
    """Further torque terms, as quadratic_drag."""
    expected: dict[str, Finite] = Field(default={})
    """Expected values that the resonator's file does not hold, by public name, SI."""
