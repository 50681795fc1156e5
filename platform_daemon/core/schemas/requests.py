"""Requests to the hardware: a series of shots, a calibration, the adoption of a calibration, the self-test."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, ConfigDict, Field, model_validator
from typing_extensions import TypeAliasType

from .base import Finite, Given, Positive, QueuedRequest, Request, Schema, Window
from .text import Line, Text

CALIBRATION_ID = r"^[A-Za-z0-9][A-Za-z0-9_-]{0,60}@\d{1,9}_\d{8}$"
SHIPPED_PRESET, TUNED_PRESET = "shipped", "tuned"
"""What `preset` of an acquisition says of the resonator's own presets; no sequence that is added has such a name."""
PresetName = Annotated[str, Field(min_length=1, max_length=500)]
ModelName = Annotated[str, Field(min_length=1, max_length=100)]
CalibrationKind = TypeAliasType("CalibrationKind", Literal["receive", "transmit"])
Hertz = Annotated[float, Field(gt=0, le=20e3, allow_inf_nan=False)]
AmplifierVolts = Annotated[float, Field(ge=1e-3, allow_inf_nan=False)]
"""Amplitude of a tone behind an amplifier, V: a smaller one is less than a step of the DAC in front of it."""


def _direction(vector: tuple[float, ...]) -> tuple[float, ...]:
    if not 1e-6 < max(map(abs, vector)) < 1e6:
        raise ValueError("the axis vector must not be zero, tiny or huge")
    return vector


ExcitationHertz = Annotated[float, Field(ge=0.01, le=20e3, allow_inf_nan=False)]
Periods = Annotated[int, Field(ge=1, le=100_000)]
FieldTesla = Annotated[float, Field(gt=0, le=1.0, allow_inf_nan=False)]
Direction = Annotated[tuple[Finite, ...], Field(strict=False, min_length=3, max_length=3), AfterValidator(_direction)]
AxisName = TypeAliasType("AxisName", Literal["x", "y", "z"])
Axis = AxisName | Direction
SwitchSeconds = Annotated[float, Field(gt=0, le=10.0, allow_inf_nan=False)]
GuardSamples = Annotated[int, Field(ge=1, le=100_000)]
RxSeconds = Annotated[float, Field(gt=0, le=600.0, allow_inf_nan=False)]
PauseSeconds = Annotated[float, Field(ge=0, le=86_400.0, allow_inf_nan=False)]
Shots = Annotated[int, Field(ge=0, le=1_000_000)]
MOST_CHANGES = 1000  # each is a shot that is planned again, in some 5 ms, before anything is answered
BlankShots = Annotated[int, Field(ge=0, le=10_000)]
Waveform = Literal["sine", "rectangle"]
PhasePlan = Literal["none", "model", "last_fit"]
Duty = Annotated[float, Field(ge=0.05, le=1, allow_inf_nan=False)]
ChirpHertz = Annotated[float, Field(ge=-20e3, le=20e3, allow_inf_nan=False)]
PhaseRadians = Annotated[float, Field(ge=-7.0, le=7.0, allow_inf_nan=False)]
Tolerance = Annotated[float, Field(ge=0, le=0.02, allow_inf_nan=False)]
PlanParameters = Annotated[dict[str, Finite], Field(max_length=50)]


class SequencePreset(Schema):
    """One shot and how often it is repeated (paper, tab:measurement_parameter)."""

    f_tx_hz: ExcitationHertz
    """Excitation frequency, Hz."""
    tx_periods: Periods
    """Whole periods in the TX window."""
    field_t: FieldTesla
    """Amplitude of the sine at the rotor, T."""
    axis: Axis
    """x, y, z, or a direction in world axes, of any length."""
    switch_s: SwitchSeconds
    """From the end of TX to the first RX sample, s."""
    guard_samples: GuardSamples
    """Samples between amplifier off and receiver connect."""
    rx_s: RxSeconds
    """RX window, s."""
    waveform: Waveform
    """Shape of a half period of the field."""
    duty: Duty
    """Share of a half period in which a rectangle is not zero."""
    chirp_hz: ChirpHertz
    """Change of the frequency from the start of TX to its end, linear in time, Hz."""
    phase_rad: PhaseRadians
    """Phase of the field at the start of TX, rad."""
    phase_plan: PhasePlan
    """none: as the frequency says; model: the field follows the velocity of the resonator's model; last_fit: the same
    with the values of the last good fit of the series."""
    plan_parameters: PlanParameters
    """Values of that model by public name, in the place of those of the resonator's file."""
    f_nat_tolerance: Tolerance
    """The plan is the best in the worst case of f_nat off by so much, relative."""
    repetitions: Shots
    """Excited shots."""
    blank_shots: BlankShots
    """Shots without excitation before them."""
    pause_s: PauseSeconds
    """Wait between shots, s."""


class SequencePatch(Request):
    """The keys of a sequence that differ from the resonator's preset; how many shots is requested by `shots` and
    `blank_shots` of the acquisition."""

    f_tx_hz: Given[ExcitationHertz] = None
    """Excitation frequency, Hz."""
    tx_periods: Given[Periods] = None
    """Whole periods of the excitation, in the TX window."""
    field_t: Given[FieldTesla] = None
    """Excitation field, T: amplitude of the sine at the rotor, at most what the platform allows."""
    axis: Given[Axis] = None
    """Axis of the excitation: x, y, z, or three numbers, as 1,0,0.5, for a direction in world axes."""
    switch_s: Given[SwitchSeconds] = None
    """From the end of TX to the first RX sample, s, at most 10."""
    guard_samples: Given[GuardSamples] = None
    """Samples between amplifier off and receiver connect, 1 to 100000."""
    rx_s: Given[RxSeconds] = None
    """RX window, s."""
    waveform: Given[Waveform] = None
    """Shape of a half period of the field: sine, or rectangle."""
    duty: Given[Duty] = None
    """Share of a half period in which a rectangle is not zero, 0.05 to 1."""
    chirp_hz: Given[ChirpHertz] = None
    """Change of the frequency from the start of TX to its end, linear in time, Hz; f_tx_hz is that at the start."""
    phase_rad: Given[PhaseRadians] = None
    """Phase of the field at the start of TX, rad."""
    phase_plan: Given[PhasePlan] = None
    """none: as the frequency says; model: the field follows the velocity of the resonator's model, integrated forward
    from rest; last_fit: the same with the values of the last good fit of the series, from the second shot on."""
    plan_parameters: Given[PlanParameters] = None
    """Values of that model by public name (f_nat_hz, m_r_am2, lambda_per_s, ...), in the place of those of the
    resonator's file."""
    f_nat_tolerance: Given[Tolerance] = None
    """The plan is the best in the worst case of f_nat off by so much either way, relative, 0 to 0.02."""
    pause_s: Given[PauseSeconds] = None
    """Wait between shots, s."""

    @model_validator(mode="before")
    @classmethod
    def _counts_belong_elsewhere(cls, keys: Any) -> Any:
        twice = {"repetitions", "blank_shots"} & set(keys if isinstance(keys, dict) else ())
        if twice:
            raise ValueError(f"{min(twice)!r} does not belong here: give the counts as `shots` and `blank_shots`")
        return keys

    def changes(self) -> dict[str, Any]:
        """The keys that were given, with their values."""
        return {name: value for name, value in self if value is not None}


class ShotChange(Request):
    """The keys of a sequence that differ in one shot."""

    f_tx_hz: Given[ExcitationHertz] = None
    """Excitation frequency, Hz."""
    tx_periods: Given[Periods] = None
    """Whole periods in the TX window."""
    field_t: Given[FieldTesla] = None
    """Amplitude of the field at the rotor, T."""
    axis: Given[Axis] = None
    """x, y, z, or a direction in world axes, of any length."""
    duty: Given[Duty] = None
    """Share of a half period in which a rectangle is not zero."""
    chirp_hz: Given[ChirpHertz] = None
    """Change of the frequency from the start of TX to its end, Hz."""
    phase_rad: Given[PhaseRadians] = None
    """Phase of the field at the start of TX, rad."""

    def changes(self) -> dict[str, Any]:
        """The keys that were given, with their values."""
        return {name: value for name, value in self if value is not None}


ShotChanges = Annotated[tuple[ShotChange, ...], Field(strict=False, min_length=1, max_length=MOST_CHANGES)]


class AcquisitionRequest(QueuedRequest):
    """A series of shots on one resonator."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"resonator": "thread", "shots": 3, "operator": "DC", "sample": "T-07"},
                {"resonator": "jewel", "shots": 1, "blank_shots": 1, "sequence": {"field_t": 4.0e-4, "rx_s": 2.0}},
            ]
        }
    )

    resonator: Annotated[str, Field(min_length=1, max_length=500)]
    """Resonator: thread, jewel, or another one of GET /resonators; on the command line also the path of a file."""
    shots: Shots = 1
    """Excited shots."""
    blank_shots: BlankShots = 0
    """Shots without excitation before them, in which the noise is measured."""
    sequence: SequencePatch = Field(default_factory=SequencePatch)
    """Keys that differ from the resonator's preset."""
    shot_changes: Given[
        Annotated[tuple[ShotChange, ...], Field(strict=False, min_length=1, max_length=MOST_CHANGES)]
    ] = None
    """What differs from shot to shot: entry k holds for the k-th excited shot, after the last one the first again."""
    preset: Given[PresetName] = None
    """shipped: the resonator's preset as it ships; tuned: the one that tune has kept, which must be there; or the name
    of a sequence, one of GET /sequences, whose keys go before those of the resonator's preset; on the command line also
    the path of a file.  Missing: the tuned one if there is one."""
    window: Window | None = "d30"
    """Evaluation window of the on-line fits: n50, d30, or seconds; null: no fit."""
    variant: ModelName | None = None
    """Model of the on-line fits, declared or adopted; null: the resonator's."""
    beyond_side_modes: Given[bool] = None
    """Allow a field above the highest that a ramp has found for this resonator; it is logged."""
    sample: Line = ""
    """Name of the sample, one line, for the record."""
    operator: Line = ""
    """Who measures, one line, for the record."""
    comment: Text = ""
    """What else is to be kept, for the record; may have several lines."""

    @property
    def mounted_resonator(self) -> str | None:
        """See QueuedRequest."""
        return self.resonator


class CalibrationRequest(QueuedRequest):
    """A calibration of the receive side with a reference dipole, or of the transmit side with a field probe."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"kind": "receive", "name": "lab", "frequencies_hz": [212, 424, 636, 848]},
                {"kind": "transmit", "amplifier_v": 1.0},
            ]
        }
    )

    kind: CalibrationKind
    """receive: the dipole along x, y, z; transmit: the probe, coil after coil."""
    name: Annotated[str, Field(max_length=61)] | None = None
    """Name of the file, without version and date; null: the kind."""
    frequencies_hz: Annotated[tuple[Hertz, ...], Field(strict=False, min_length=2, max_length=100)] = (
        *(100.0, 212.0, 424.0, 636.0, 848.0, 1272.0),
        *(2120.0, 4000.0, 8000.0),
    )
    """Frequencies, Hz, two different ones at least."""
    repetitions: Annotated[int, Field(ge=1, le=1000)] = 2
    """Shots per direction and frequency."""
    listen_s: Annotated[float, Field(gt=0, le=60, allow_inf_nan=False)] = 0.4
    """Length of a shot, s; receive only."""
    amplifier_v: AmplifierVolts = 1.0
    """Amplitude on each coil, V; transmit only."""
    temperature_span_c: Positive = 5.0
    """The calibration holds within so many degrees Celsius of the temperatures at which it was made."""

    @property
    def file_name(self) -> str:
        """Name of the file, without version and date."""
        return self.name or self.kind


class ActivationRequest(Request):
    """A calibration to use from the next series on."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"kind": "receive", "calibration": "lab@2_20261121"}, {"kind": "transmit"}]}
    )

    kind: CalibrationKind
    """Which side."""
    calibration: Annotated[str, Field(pattern=CALIBRATION_ID)] | None = None
    """One that a job has written, as lab@2_20261121; null: the file that the platform file names, read again."""


class SelfTestOptions(Request):
    """The self-test before a series, table `[self_test]` of a platform file: a weak tone per coil."""

    enabled: bool | None = None
    """null: on for real devices, off for a platform that lives in simulated time."""
    amplifier_v: AmplifierVolts = 1.0
    """Amplitude on each coil, V, at least 1e-3."""
    frequency_hz: Positive = 4000.0
    """Frequency of the tones, Hz: far above any resonator, so that none is moved."""
    tone_s: Annotated[float, Field(ge=4e-3, le=1.0)] = 12e-3
    """Length of a tone, s."""
    isolation_db: Annotated[float, Field(ge=0, le=200)] | None = None
    """Isolation of the switch at that frequency, dB; null: unknown, the channels are compared with each other."""
    tolerance: Annotated[float, Field(gt=0, lt=1)] = 0.3
    """Of the gain, relative."""
