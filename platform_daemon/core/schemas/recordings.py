"""Recordings: the list of a folder, what one holds, and its dm/dt for a plot."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field
from typing_extensions import TypeAliasType

from platform_daemon.core.schemas.requests import ModelName

from .base import Absent, ClockKind, Interval, ListPage, Schema, Vector, example
from .problems import UnreadableFile
from .value_sources import ValueSource

RecordingLayout = TypeAliasType("RecordingLayout", Literal["own", "minimal"])
Quantity = TypeAliasType("Quantity", Literal["dmdt", "voltage"])
QuantityUnit = TypeAliasType("QuantityUnit", Literal["A m^2/s", "V"])


class WindowLength(Schema):
    """Length of one window of a shot."""

    samples: int
    """Samples."""
    seconds: float
    """The same in s."""


class ShotWindows(Schema):
    """The three windows of a shot, one after the other."""

    tx: WindowLength
    """Excitation."""
    switch: WindowLength
    """From the end of TX to the first RX sample."""
    rx: WindowLength
    """Reception."""


class FrequencyResponseExtent(Schema):
    """Where the frequency response of a calibration is known."""

    points: int
    """Frequencies."""
    from_hz: float
    """The lowest, Hz."""
    to_hz: float
    """The highest, Hz."""


class CalibrationInfo(Schema):
    """The receive calibration of a recording (paper eq:u(t,p,R)); null where it does not say."""

    id: str | None
    """Its name."""
    date: str | None
    """When it was made, ISO 8601."""
    lna_gain: float | None
    """Gain of the low-noise amplifier at which it holds, V/V."""
    sensitivity: tuple[Vector, ...]
    """Voltage per dm/dt on the world axes, V/(A m^2/s) = T/A, (channels, 3)."""
    sensitivity_std: tuple[Vector, ...] | None
    """Its standard deviation, T/A, (channels, 3)."""
    relative_std: float | None
    """Standard uncertainty of all of it together, relative."""
    valid_hz: Interval | None
    """Between which frequencies it holds, Hz."""
    valid_c: Interval | None
    """Between which temperatures it holds, degrees Celsius."""
    temperature_c: float | None
    """At which it was made, degrees Celsius."""
    transmit: str | None
    """Identifier of the transmit calibration of the shots; null: coils as the platform file declares them."""
    response: FrequencyResponseExtent | None
    """Frequency response of the channels; null: flat."""


class ExcitationInfo(Schema):
    """What a shot was excited with."""

    waveform: str
    """Form of the signal."""
    requested_hz: float
    """Frequency that was requested, Hz."""
    realised_hz: float
    """The one that fits whole periods into whole samples, Hz."""
    field_t: float
    """Peak of the field at the rotor, T."""
    axis: Vector
    """Direction of the field in world axes, a unit vector."""
    periods: float
    """Periods."""
    phase_rad: float
    """Phase of the sine at the first TX sample, rad."""
    current_a: tuple[float, ...]
    """Peak currents of the coils, A, (coils,)."""


class FrameDescription(Schema):
    """One frame of a recording."""

    frame: int
    """Number of the frame, from 0."""
    shot: int
    """Number of the shot in its series, from 1."""
    time_stamp: str | None
    """When it was triggered, ISO 8601."""
    temperature_c: float | None
    """Temperature of the platform, degrees Celsius; null: it was not measured."""
    verdict: str
    """good, or refused: not to be used."""
    reason: str
    """Why it was refused; empty for a good one."""
    flags: tuple[str, ...]
    """What the devices complained of."""
    valid_samples: int
    """Samples that were recorded; those behind are padding."""
    blank: bool
    """A shot without excitation."""
    excitation: ExcitationInfo | None
    """What it was excited with; null: not said."""
    step: Absent[int] = None
    """Number of its step in a procedure, from 1; missing outside of procedures."""
    step_name: Absent[str] = None
    """What the step is for: tune, ramp, series or sweep; missing: the file does not say."""
    values: Absent[dict[str, float | str]] = None
    """What the step was made with, by key, in the unit that the key names; missing outside of procedures."""
    joined: Absent[bool] = None
    """The first shot after the series had been cut off and was resumed; missing for all others."""
    late_s: Absent[float] = None
    """From when it was due to its trigger, s: the first when its series began, others a pause after the last sample
    of the shot before; missing: unknown."""


class RecordingLinks(Schema):
    """Where the parts of a recording are."""

    self: str
    """The description."""
    file: str
    """The file itself."""
    dmdt: str
    """Calibrated dm/dt of its first frame."""


class RecordingInfo(Schema):
    """What a recording holds; null where the file does not say."""

    model_config = ConfigDict(json_schema_extra=example("recording_info"))

    id: Absent[str] = None
    """Id by REST: the file name without its last suffix; missing on the command line."""
    file: str
    """Path as it was named; by REST the file's name."""
    size_bytes: int
    """Size of the file, bytes."""
    layout: RecordingLayout
    """own: recorded by this software, with everything about it; minimal: from elsewhere."""
    variant: str | None
    """Bearing of the resonator: thread or jewel."""
    frames: int
    """Frames."""
    good: int
    """Frames that may be used."""
    channels: int
    """Channels."""
    channel_names: tuple[str, ...]
    """Their names; empty: not said."""
    rate_hz: float
    """Sampling rate, Hz."""
    base_frequency_hz: float
    """Clock of the card, Hz."""
    decimation: int
    """Clock periods per sample."""
    windows: ShotWindows
    """Length of the windows."""
    calibration: CalibrationInfo | None
    """Receive calibration; null: the file has none."""
    incomplete: str | None
    """Why the series has fewer shots than planned; null: it is complete."""
    sample: str | None
    """Name of the sample."""
    operator: str | None
    """Who measured."""
    comment: str | None
    """What the operator wrote."""
    title: str | None
    """Title of the series."""
    start_time: str | None
    """When it began, ISO 8601."""
    clock: Absent[ClockKind] = None
    """Clock that this and the times of the shots go by; missing: the file does not say."""
    platform: str | None
    """Name of the platform."""
    devices: dict[str, str]
    """Identity by device."""
    software_version: str | None
    """Version of the software that recorded it."""
    fits: tuple[str, ...]
    """Names of the on-line fits in the file."""
    value_sources: Absent[tuple[ValueSource, ...]] = None
    """Where the values of the sequence come from, of a procedure those of its last step; missing: the file does not
    say."""
    shots: tuple[FrameDescription, ...]
    """Frame by frame, by REST those that were asked for; empty for a file from elsewhere."""
    links: Absent[RecordingLinks] = None
    """Where its parts are, by REST; missing on the command line."""


class RecordingSummary(Schema):
    """One line of the list of recordings."""

    id: str
    """Id."""
    path: str
    """Name of the file."""
    size_bytes: int
    """Size of the file, bytes."""
    frames: int
    """Frames."""
    variant: str | None
    """Bearing of the resonator; null: not said."""
    date: str
    """When the series began, ISO 8601; of a file from elsewhere the file's own date."""
    clock: Absent[ClockKind] = None
    """Clock that the date goes by; missing: the file does not say."""
    incomplete: str | None
    """Why the series has fewer shots than planned; null: it is complete."""
    sample: str | None = None
    """Name of the sample; null, here and below: the file does not say, or the index has not read it yet."""
    resonator: str | None = None
    """Name of the resonator, as its file says."""
    good: int | None = None
    """Frames that may be used."""
    refused: int | None = None
    """Frames that were refused."""
    f_nat_hz: float | None = None
    """Natural frequency, mean of the good on-line fits, Hz; null: there are none, here and below."""
    m_r_am2: float | None = None
    """Magnetic moment of the rotor, mean of the good on-line fits, A m^2."""
    links: RecordingLinks
    """Where its parts are."""


class RecordingListing(ListPage[RecordingSummary]):
    """Everything in the folder of recordings, by name."""

    model_config = ConfigDict(json_schema_extra=example("recording_listing"))

    broken: tuple[UnreadableFile, ...]
    """Files of this page that cannot be used, each with the reason."""


class RecoveryReport(Schema):
    """What became of shots that were kept in single files."""

    model_config = ConfigDict(json_schema_extra=example("recovery_report"))

    recordings: tuple[str, ...]
    """Ids of the recordings that were made of them."""
    failed: tuple[UnreadableFile, ...]
    """Those that are still kept so, each with the reason."""


class DmdtSeries(Schema):
    """Calibrated dm/dt of one frame for a plot: per bucket the smallest and the largest value, so that no peak is lost;
    the volts at the ADC if the recording has no calibration."""

    model_config = ConfigDict(json_schema_extra=example("dmdt_series"))

    recording: str
    """Id of the recording."""
    frame: int
    """Number of the frame, from 0."""
    quantity: Quantity
    """What the values are."""
    unit: QuantityUnit
    """Unit of the values."""
    channels: tuple[str, ...]
    """World axes x, y, z; of voltages the numbers of the channels."""
    sampling_rate_hz: float
    """Sampling rate, Hz."""
    samples: int
    """Samples of the time range that was requested."""
    samples_per_point: int
    """Samples per bucket."""
    t_s: tuple[float, ...]
    """Begin of each bucket, s after the first RX sample, (points,)."""
    minimum: tuple[tuple[float, ...], ...]
    """Smallest value of each bucket, (channels, points)."""
    maximum: tuple[tuple[float, ...], ...]
    """Largest value of each bucket, (channels, points)."""
    notes: tuple[str, ...]
    """What was assumed."""


class TableColumn(Schema):
    """A column of a table from elsewhere."""

    name: str
    """As the table has it."""
    shape: tuple[int, ...]
    """(rows,); of an array in npz or MATLAB's files all of its dimensions."""
    unit: str | None
    """As its name, or the TOML file next to the table, says; null: neither says one."""
    read_as: Literal["time", "signal"] | None
    """What it is taken for; null: it is left out."""
    lowest: float | None
    """Smallest finite number, in its unit; null: there is none."""
    highest: float | None
    """Largest finite number, in its unit; null: there is none."""


class AngleInfo(Schema):
    """What a file of an angle over time holds."""

    file: str
    """Path as it was named."""
    size_bytes: int
    """Size of the file, bytes."""
    columns: tuple[TableColumn, ...]
    """Of a table; empty: it is HDF5 with /time and /signal."""
    samples: int
    """Samples of the longest stretch with an even clock."""
    rate_hz: float
    """Sampling rate, Hz."""
    lowest_rad: float | None
    """Smallest angle, rad; null: no sample is a number."""
    highest_rad: float | None
    """Largest angle, rad; null: no sample is a number."""
    notes: tuple[str, ...]
    """What is wrong with the time, in words; empty: nothing."""


RecordingId = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$", max_length=200)]


Frames = Annotated[list[Annotated[int, Field(ge=0)]], Field(min_length=1, max_length=100_000)] | None


StepName = Annotated[str, Field(pattern=r"^(\d{1,6}|[a-z]{1,20})$")]
"""Number of a step of a procedure, from 1, or its name, of several with that name the last."""


Terms = Annotated[list[ModelName], Field(max_length=8)]


Observable = TypeAliasType("Observable", Literal["dmdt", "angle"])
