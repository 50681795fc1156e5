"""What is asked of stored data and of plans: fits, diagnoses, adopted models, predictions, defects."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field, model_validator
from typing_extensions import TypeAliasType

from .base import Finite, NamedWindow, Positive, Request, Window
from .design import Bearing, Defect, Infinite, JewelPivot, LateralDirection
from .parameters import PAPER_NOISE_AM2_PER_S
from .requests import ModelName
from .text import Name, OneLine, SeveralLines, Text

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
    by: Name
    """Who adopts it."""
    effects: Annotated[list[str], Field(max_length=20)] = Field(default=[])
    """Ids of the effects to adopt; empty: all."""
    free: Annotated[list[str], Field(max_length=20)] = Field(default=[])
    """Ids of torque effects whose strength fits estimate anew."""
    force: Text = ""
    """Why it is adopted although the data are not explained; is kept as evidence."""


class RetirementRequest(Request):
    """A version of an adopted model is taken out of use."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"reason": "thread replaced", "by": "DC"}]})

    reason: Annotated[str, Field(min_length=1, max_length=2000), SeveralLines]
    """Why; is kept."""
    by: Annotated[str, Field(max_length=200), OneLine] = ""
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


MOST_CASES = 20_000
_Quarter = Annotated[float, Field(ge=-90, le=90, allow_inf_nan=False)]
_Sizes = Field(min_length=1, max_length=1000)
_Shift = Annotated[float, Field(ge=-1000, le=1000, allow_inf_nan=False)]


class DefectsRequest(Request):
    """A manufacturing defect in some sizes, at some deflections; at most 20 000 cases."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"bearing": "jewel", "defect": "stator_tilt", "eps_deg": [0.5, 2.0], "phi_deg": [30.0]},
                {"bearing": "thread", "defect": "lateral", "dy_mm": [0.1], "thread_length_over_r": "inf"},
            ]
        }
    )

    bearing: Bearing
    """How the rotor is held."""
    defect: Defect
    """stator_tilt, lateral; of a thread rotor_tilt, of a jewel jewel_tilt."""
    eps_deg: Annotated[list[_Quarter], _Sizes] | None = None
    """Error angles of a tilt, degrees; beyond 90 the magnet is the other way round."""
    dy_mm: Annotated[list[_Shift], _Sizes] | None = None
    """Sizes of a displacement, mm."""
    phi_deg: Annotated[list[_Quarter], _Sizes] = Field(default=[30.0])
    """Deflections about the new axis, degrees; beyond 90 the magnets repel each other."""
    cup_radius_over_r: Finite | Infinite | None = None
    """R/r of a jewel bearing, "inf": flat; null: the resonator's, else the paper's 5/3."""
    thread_length_over_r: Finite | Infinite | None = None
    """l/r of a thread bearing, "inf": it does not tilt; null: the resonator's, else the paper's 8."""
    pivot: JewelPivot | None = None
    """About what a jewel is tilted; null: the contact."""
    direction: LateralDirection | None = None
    """Of a displacement, against the stator's magnetisation; null: along."""
    resonator: ModelName | None = None
    """Name of a resonator, one of GET /resonators, of which the magnets are; null: the paper's design point."""

    @property
    def sizes(self) -> list[float]:
        """Degrees of a tilt, mm of a displacement."""
        return (self.dy_mm if self.defect == "lateral" else self.eps_deg) or []

    @model_validator(mode="after")
    def _bounded(self) -> DefectsRequest:
        if (cases := len(self.sizes) * len(self.phi_deg)) > MOST_CASES:
            raise ValueError(f"{cases} cases are more than {MOST_CASES}: ask for fewer sizes or deflections")
        return self
