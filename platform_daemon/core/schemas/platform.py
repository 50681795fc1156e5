"""The platform and its daemon: devices, state, readiness, self-test, resonators."""

from __future__ import annotations

from typing import Literal

from pydantic import ConfigDict
from typing_extensions import TypeAliasType

from .base import ListPage, Schema, example
from .calibrations import CalibrationName
from .problems import UnreadableFile
from .requests import SequencePatch, SequencePreset

CardStateName = TypeAliasType("CardStateName", Literal["idle", "programmed", "armed", "running", "closed"])
SwitchPositionName = TypeAliasType("SwitchPositionName", Literal["transmit", "receive", "moving"])
DeviceKind = TypeAliasType("DeviceKind", Literal["io_card", "tx_rx_switch", "power_amplifier", "lna", "thermometer"])


class DeviceIdentity(Schema):
    """What a device says of itself; empty where it does not tell."""

    manufacturer: str
    """Manufacturer."""
    model: str
    """Model."""
    serial: str
    """Serial number."""
    firmware: str
    """Version of its firmware."""


class _Identified(Schema):
    identity: DeviceIdentity | None
    """What the device says of itself; null: nothing."""


class IoCardState(Schema):
    """State of the I/O card."""

    state: CardStateName
    """idle, programmed, armed, running or closed."""
    inputs: int
    """Receive channels."""
    outputs: int
    """Transmit channels."""
    sampling_rate_hz: float
    """Sampling rate, Hz."""


class SwitchState(Schema):
    """State of the Tx/Rx switch."""

    position: SwitchPositionName
    """transmit, receive, or moving."""
    total_time_s: float
    """From the command until receive data are good, s."""


class AmplifierState(Schema):
    """State of the power amplifier."""

    enabled: bool
    """It may put out power."""
    muted: bool
    """Its output is muted."""
    fault: str | None
    """The fault that is latched; null: healthy."""
    temperature_c: float | None
    """Of the heat sink, degrees Celsius; null: it does not tell."""
    clipped: bool
    """It has clipped since it was enabled."""


class LnaState(Schema):
    """State of the low-noise amplifier."""

    gain: float
    """Gain, V/V."""
    overloaded: bool
    """A channel was overloaded since that was last cleared, which every shot does."""


class ThermometerState(Schema):
    """State of the thermometer."""

    temperature_c: float
    """Temperature of the platform, degrees Celsius."""


class NoState(Schema):
    """The device did not answer."""


class IoCardStatus(IoCardState, _Identified):
    """The I/O card as last read back."""


class SwitchStatus(SwitchState, _Identified):
    """The Tx/Rx switch as last read back."""


class AmplifierStatusReport(AmplifierState, _Identified):
    """The power amplifier as last read back."""


class LnaStatus(LnaState, _Identified):
    """The low-noise amplifier as last read back."""


class PlatformStatus(Schema):
    """The platform as last read back: every second while idle, in the RX window of each shot of a series."""

    model_config = ConfigDict(json_schema_extra=example("platform_status"))

    platform: str
    """Name of the platform."""
    io_card: IoCardStatus
    """The I/O card."""
    tx_rx_switch: SwitchStatus
    """The Tx/Rx switch."""
    power_amplifier: AmplifierStatusReport
    """The power amplifier."""
    lna: LnaStatus
    """The low-noise amplifier."""
    temperature_c: float | None
    """Temperature of the platform, degrees Celsius; null: it is not measured."""
    error: str | None
    """Why a device could not be read back; null: all answered."""
    read_at: str
    """When all devices answered last, ISO 8601."""
    calibration: CalibrationName
    """Receive calibration in use."""
    transmit_calibration: CalibrationName | None
    """Transmit calibration in use; null: coils as the platform file declares them."""
    interlock: str | None
    """Why power must stay off: outputs that could not be confirmed off; null: power may go out."""
    running: str | None
    """Id of the series or calibration that runs; null: none."""
    queued: tuple[str, ...]
    """Ids of those that wait, the next one first."""


AnyDeviceState = IoCardState | SwitchState | AmplifierState | LnaState | ThermometerState | NoState


class DeviceReport(Schema):
    """One device: who it is, its state, and what went wrong."""

    device: DeviceKind
    """What it is in the platform: io_card, tx_rx_switch, power_amplifier, lna or thermometer."""
    identity: DeviceIdentity | None
    """What it says of itself; null: nothing."""
    state: AnyDeviceState
    """Its state; empty if it did not answer."""
    error: str | None
    """Why it did not answer; null: it did."""


class DeviceSurvey(Schema):
    """What `devices --json` writes: every device that the platform file names."""

    model_config = ConfigDict(json_schema_extra=example("device_survey"))

    platform: str
    """Name of the platform."""
    devices: tuple[DeviceReport, ...]
    """Device by device."""


class DeviceError(Schema):
    """The last thing that went wrong with a device."""

    error: str
    """What, why and the remedy, in one line."""
    at: str
    """When, ISO 8601."""


class DeviceReadback(DeviceReport):
    """A device as last read back."""

    read_at: str
    """When it was queried, ISO 8601."""
    last_error: DeviceError | None
    """The last thing that went wrong with it; null: nothing yet."""


class DeviceListing(ListPage[DeviceReadback]):
    """Every device of the platform, also one that does not answer."""

    model_config = ConfigDict(json_schema_extra=example("device_listing"))


class FaultReset(Schema):
    """What the latched fault of the power amplifier was, and the amplifier after its reset."""

    model_config = ConfigDict(json_schema_extra=example("fault_reset"))

    fault: str | None
    """The fault that was cleared; null: there was none."""
    power_amplifier: AmplifierState
    """The amplifier now: disabled and muted."""


class ResonatorInfo(Schema):
    """A resonator that can be measured."""

    id: str
    """Name to use in an acquisition."""
    name: str
    """Its name in words."""
    variant: str
    """Its bearing: thread or jewel."""
    sequence: SequencePreset
    """The preset of its sequence."""


class ResonatorListing(ListPage[ResonatorInfo]):
    """Resonators that can be measured."""

    model_config = ConfigDict(json_schema_extra=example("resonator_listing"))

    broken: tuple[UnreadableFile, ...]
    """Resonators of this page whose files are damaged, each with the reason."""


class SequenceInfo(Schema):
    """A sequence that has a name."""

    id: str
    """Name to use as `preset` of an acquisition."""
    sequence: SequencePatch
    """The keys that it sets."""


class SequenceListing(ListPage[SequenceInfo]):
    """Sequences that have a name."""

    model_config = ConfigDict(json_schema_extra=example("sequence_listing"))

    broken: tuple[UnreadableFile, ...]
    """Sequences of this page whose files are damaged, each with the reason."""


class CatalogueEntry(Schema):
    """A resonator or a sequence that was added."""

    model_config = ConfigDict(json_schema_extra=example("catalogue_entry"))

    name: str
    """Its name, which means the newest version."""
    version: int
    """Counts from 1; a version never changes."""
    label: str
    """NAME@VERSION."""


class EntryPoints(Schema):
    """Where everything is."""

    model_config = ConfigDict(json_schema_extra=example("entry_points"))

    name: str
    """Name of this program."""
    version: str
    """Its version."""
    links: dict[str, str]
    """Path by what is there."""


class Readiness(Schema):
    """Whether every part has warmed up; requests are served all the same."""

    model_config = ConfigDict(json_schema_extra=example("readiness"))

    ready: bool
    """All parts have."""
    warm: dict[str, bool]
    """By part."""
    waiting_for: dict[str, str]
    """What each part that has not warmed up does at present, and how long that takes."""
