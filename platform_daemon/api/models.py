"""The bodies that the API takes and gives; units are part of every name."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from platform_daemon.engine import AcquisitionRequest, ActivationRequest, CalibrationRequest
from platform_daemon.schemas import PAPER_NOISE_AM2_PER_S
from platform_daemon.settings import shipped

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NAME = r"^[A-Za-z0-9][A-Za-z0-9_.-]*$"


def _ships(name: str) -> str:
    if name not in shipped("resonators"):
        raise ValueError(f"no resonator is called {name!r}, there are: {', '.join(shipped('resonators'))}")
    return name


ShippedResonator = Annotated[str, Field(max_length=100, description="one of GET /resonators"), AfterValidator(_ships)]


class AcquisitionBody(AcquisitionRequest):
    """An acquisition as asked for by REST; resonators are named, never given as paths."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"resonator": "thread", "shots": 3, "operator": "DC", "sample": "T-07"},
                {"resonator": "jewel", "shots": 1, "blank_shots": 1, "sequence": {"field_t": 4.0e-4, "rx_s": 2.0}},
            ]
        }
    )

    resonator: ShippedResonator


class CalibrationBody(CalibrationRequest):
    """A calibration as asked for by REST."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"kind": "receive", "name": "lab", "frequencies_hz": [212, 424, 636, 848]},
                {"kind": "transmit", "amplifier_v": 1.0},
            ]
        }
    )


class AdoptionBody(ActivationRequest):
    """A calibration to use from the next series on."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"kind": "receive", "calibration": "lab@2_20261121"}, {"kind": "transmit"}]}
    )


class NamedCalibration(BaseModel):
    """Name and date (ISO 8601) of a calibration."""

    identifier: str
    date: str


class InUseModel(BaseModel):
    """The calibrations in use; transmit null: coils as the platform file declares them."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "calibration": {"identifier": "lab@2_20261121", "date": "2026-11-21T10:15:00+00:00"},
                    "transmit_calibration": None,
                }
            ]
        }
    )

    calibration: NamedCalibration
    transmit_calibration: NamedCalibration | None


class AmplifierModel(BaseModel):
    """The power amplifier as read back; fault: null if healthy."""

    enabled: bool
    muted: bool
    fault: str | None
    temperature_c: float | None
    clipped: bool


class ResetModel(BaseModel):
    """What the fault was (null: there was none), and the amplifier after the reset."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "fault": "over-current",
                    "power_amplifier": {
                        "enabled": False,
                        "muted": True,
                        "fault": None,
                        "temperature_c": 31.5,
                        "clipped": False,
                    },
                }
            ]
        }
    )

    fault: str | None
    power_amplifier: AmplifierModel


FrameNumbers = Annotated[list[Annotated[int, Field(ge=0)]], Field(min_length=1, max_length=100_000)] | None


class FitBody(BaseModel):
    """A fit of a stored recording; window: "n50", "d30" or seconds; variant: thread, jewel or another declared model;
    default: what the recording says.  terms: further torque terms, as quadratic_drag.

    fixed: parameters held, by name; hints: losses held only in frames whose window cannot tell them apart.
    frames: from 0; default: all.
    """

    model_config = ConfigDict(
        extra="forbid",
        strict=True,
        json_schema_extra={"examples": [{"recording": "acquisition-20261121T101500-1a2b3c", "window": "n50"}]},
    )

    recording: Annotated[str, Field(pattern=NAME, max_length=200)]
    variant: Annotated[str, Field(max_length=100)] | None = None
    terms: Annotated[list[str], Field(max_length=8)] = Field(default_factory=list)
    window: Literal["n50", "d30"] | Annotated[float, Field(gt=0, allow_inf_nan=False)] = "d30"
    fixed: dict[str, Annotated[float, Field(allow_inf_nan=False)]] = Field(default_factory=dict)
    hints: dict[str, Annotated[float, Field(allow_inf_nan=False)]] = Field(default_factory=dict)
    frames: FrameNumbers = None


Identifier = Annotated[str, Field(pattern=NAME, max_length=200)]


class PartBody(BaseModel):
    """Some frames of a recording, from 0; null: all."""

    model_config = ConfigDict(extra="forbid", strict=True)

    recording: Identifier
    frames: FrameNumbers = None


class DiagnosisBody(BaseModel):
    """A diagnosis of one specimen.  recordings: ids, or objects with `frames`; several are diagnosed together.

    variant: the declared model, default what the recordings say; base: a declared or adopted model to start from in its
    place; observable: default what the recordings hold.
    """

    model_config = ConfigDict(
        extra="forbid",
        strict=True,
        json_schema_extra={
            "examples": [
                {"recordings": ["acquisition-20261121T101500-1a2b3c"]},
                {"recordings": ["a", "b"], "base": "quiet"},
            ]
        },
    )

    recordings: Annotated[list[Identifier | PartBody], Field(min_length=1, max_length=200)]
    variant: Annotated[str, Field(max_length=100)] | None = None
    base: Annotated[str, Field(max_length=100)] | None = None
    observable: Literal["dmdt", "angle"] | None = None

    def parts(self) -> list[PartBody]:
        """Every recording with its frames."""
        return [p if isinstance(p, PartBody) else PartBody(recording=p) for p in self.recordings]


class AdoptBody(BaseModel):
    """Adoption of what a diagnosis names.  effects: ids, empty: all; free: torque effects whose strength fits estimate
    anew; force: why it is adopted although the data are not explained, is kept as evidence."""

    model_config = ConfigDict(
        extra="forbid", strict=True, json_schema_extra={"examples": [{"name": "quiet", "by": "DC"}]}
    )

    name: Annotated[str, Field(max_length=64)]
    by: Annotated[str, Field(min_length=1, max_length=200)]
    effects: Annotated[list[str], Field(max_length=20)] = []
    free: Annotated[list[str], Field(max_length=20)] = []
    force: Annotated[str, Field(max_length=2000)] = ""


class RetireBody(BaseModel):
    """Why a version of an adopted model is taken out of use, and by whom; both are kept."""

    model_config = ConfigDict(extra="forbid", strict=True)

    reason: Annotated[str, Field(min_length=1, max_length=2000)]
    by: Annotated[str, Field(max_length=200)] = ""


class PredictBody(BaseModel):
    """A planned measurement; phi_max_rad: default the paper's; noise of x, y, z per sample; fixed: names held.

    variant, terms: the model to be fitted, default the resonator's; expected: values that its file does not hold.
    """

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={"examples": [{"resonator": "jewel", "windows": ["n50", 1.0], "phi_max_rad": 0.7}]},
    )

    resonator: ShippedResonator
    windows: Annotated[
        list[Literal["n50", "d30"] | Annotated[float, Field(gt=0, le=100)]], Field(min_length=1, max_length=20)
    ] = ["n50", "d30"]
    phi_max_rad: Annotated[float, Field(gt=0, lt=1.5)] | None = None
    noise_am2_per_s: tuple[Positive, Positive, Positive] = PAPER_NOISE_AM2_PER_S
    sampling_rate_hz: Positive = 125e6 / 2048
    fixed: Annotated[list[str], Field(max_length=9)] = []
    variant: Annotated[str, Field(max_length=100)] | None = None
    terms: Annotated[list[str], Field(max_length=8)] = []
    expected: dict[str, Annotated[float, Field(allow_inf_nan=False)]] = {}


class ProgressModel(BaseModel):
    """How far a job is: done of total in unit, phase, share 0 to 1, seconds left (null: not known yet)."""

    done: float
    total: float
    unit: str
    phase: str
    fraction: float
    time_left_s: float | None


class JobModel(BaseModel):
    """A job.  `result` grows while it runs; `error` is a problem details object."""

    id: str
    kind: str
    state: Literal["queued", "running", "done", "failed", "cancelled"]
    progress: ProgressModel
    created: str | None
    started: str | None
    finished: str | None
    request: dict[str, Any]
    result: dict[str, Any]
    warnings: list[str]
    error: dict[str, Any] | None
    links: dict[str, str]


class ProblemModel(BaseModel):
    """RFC 9457 problem details."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "type": "/problems/sequence-rejected",
                    "title": "Sequence rejected",
                    "status": 422,
                    "detail": "sequence.field_t: the field amplitude would be 0.005 T. limits.max_field_t is 0.001 T. "
                    "Remedy: lower sequence.field_t.",
                    "where": "sequence.field_t",
                    "remedy": "lower sequence.field_t",
                }
            ]
        }
    )

    type: str
    title: str
    status: int
    detail: str | None = None
    instance: str | None = None
    where: str | None = None
    remedy: str | None = None


class DmdtModel(BaseModel):
    """Calibrated dm/dt of one frame for a plot: per bucket of `samples_per_point` samples the smallest and the largest
    value, so that no peak is lost; t_s is the bucket's start, 0 at the first RX sample."""

    recording: str
    frame: int
    quantity: Literal["dmdt", "voltage"]
    unit: str
    channels: list[str]
    sampling_rate_hz: float
    samples: int
    samples_per_point: int
    t_s: list[float]
    minimum: list[list[float]]
    maximum: list[list[float]]
    notes: list[str]
