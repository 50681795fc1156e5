"""Series of shots: what one would be, and what came out of one."""

from __future__ import annotations

from collections.abc import Sequence

from pydantic import ConfigDict

from .base import Absent, ListPage, Schema, Verdict, example
from .fits import FitReport, FrameFit
from .value_sources import ValueSource


class ShotSummary(Schema):
    """One shot as it would be played."""

    blank: bool
    """A shot without excitation."""
    f_tx_requested_hz: float
    """Excitation frequency that was requested, Hz."""
    f_tx_realised_hz: float
    """The one that fits whole periods into whole samples; of a chirp at its start, of a planned drive the mean, Hz."""
    field_t: float
    """Amplitude of the excitation field at the rotor, T."""
    tx_periods: int
    """Periods of excitation."""
    tx_samples: int
    """Length of the TX window, samples."""
    switch_samples: int
    """From the end of TX to the first RX sample, samples."""
    rx_samples: int
    """Length of the RX window, samples."""
    t_tx_s: float
    """Length of the TX window, s."""
    t_switch_s: float
    """From the end of TX to the first RX sample, s."""
    t_rx_s: float
    """Length of the RX window, s."""
    coil_current_a: dict[str, float]
    """Amplitude of the current by coil, A."""
    amplifier_v: dict[str, float]
    """Amplitude at the amplifier's output by coil, V."""
    peak_field_t: float
    """Largest field at the rotor, from the exact samples of the drive through the loops of the coils, T."""
    peak_current_a: dict[str, float]
    """Largest current by coil, from the same, A."""
    peak_amplifier_v: dict[str, float]
    """Largest voltage at the amplifier's output by coil, from the same, V."""
    i2t_a2s: dict[str, float]
    """Integral of the squared current by coil, from the same, A^2 s."""
    energy_j: float
    """What the amplifier delivers, from the same, J."""
    heat_per_shot_j: float
    """Heat in the coils, from the same, J."""
    planned_phi_max_rad: Absent[float] = None
    """Deflection that the model reaches, rad; only of a drive that was planned by it."""
    duration_s: float
    """Length of the shot, s."""


class SettleCheck(Schema):
    """How much of the swing remains when the next shot begins, by the expected damping."""

    remaining_rad: float
    """Largest deflection then, rad."""
    share: float
    """Its share in the largest deflection after TX, 0 to 1."""


class AcquisitionSummary(Schema):
    """A series as it would be: what would be played, how long it takes, how much disk it needs."""

    model_config = ConfigDict(json_schema_extra=example("acquisition_summary"))

    resonator: str
    """Name of the resonator."""
    variant: str
    """Its bearing: thread or jewel."""
    model: str
    """Model of the on-line fits."""
    shots: int
    """Shots in all, blank ones included."""
    shot: ShotSummary
    """One excited shot, the first."""
    shots_in_turn: Absent[tuple[ShotSummary, ...]] = None
    """All excited shots that differ, in order; only if shots were requested to differ."""
    duration_s: float
    """Length of the series, pauses included, s."""
    disk_bytes: int
    """Size of the samples on disk, bytes."""
    settle: SettleCheck
    """Does the resonator come to rest between the shots?"""
    value_sources: Absent[tuple[ValueSource, ...]] = None
    """Where the values of the series come from, and the limits that hold for it."""
    warnings: tuple[str, ...]
    """What may spoil the series."""


class AcquisitionResult(Schema):
    """What a series has brought so far; empty before its first shot is on disk."""

    recording: Absent[str] = None
    """Id of the recording."""
    file: Absent[str] = None
    """Name of its file."""
    shots: Absent[int] = None
    """Shots on disk."""
    refused: Absent[int] = None
    """Excited shots among them that are marked refused; missing: none."""
    fit: Absent[FitReport] = None
    """The on-line fits, once the series has ended."""
    value_sources: Absent[tuple[ValueSource, ...]] = None
    """Where the values of the series come from, and the limits that hold for it."""


class ShotReading(Schema):
    """What a resonator that is calibrated as a sensor reads by one shot, or by the mean of several."""

    name: str
    """The quantity in words."""
    unit: str
    """Its unit."""
    calibration: str
    """KEY@VERSION of the calibration."""
    value: float | None
    """In the unit; null: there is no reading."""
    U: float | None
    """Expanded uncertainty, 95 %, in the unit; null: there is no reading."""
    reason: str | None
    """Why there is no reading; null: there is one."""


class ShotReport(Schema):
    """One shot on disk, and its on-line fit."""

    shot: int
    """Number in its acquisition, from 1."""
    frame: int
    """Its frame in the recording, from 0."""
    time_stamp: str | None
    """When it was triggered, ISO 8601."""
    blank: bool
    """A shot without excitation."""
    verdict: Verdict
    """Refused: it must not be used."""
    reason: str | None
    """Why it was refused; null for a good one."""
    temperature_c: float | None
    """Temperature of the platform, degrees Celsius; null: it was not measured."""
    fit: FrameFit | None
    """Its fit; null: it is not there yet, or none was requested."""
    measurand: Absent[ShotReading] = None
    """What it reads; missing: it has no good fit, or its resonator is not calibrated as a sensor."""


class ShotPage(ListPage[ShotReport]):
    """Some shots of an acquisition, in order."""

    model_config = ConfigDict(json_schema_extra=example("shot_page"))

    @classmethod
    def cut(cls, shots: Sequence[ShotReport], series: str, *, after: int, limit: int) -> ShotPage:
        """At most `limit` of the shots of a series, with numbers above `after`."""
        end = after + limit
        more = f"/acquisitions/{series}/shots?after={end}&limit={limit}" if end < len(shots) else None
        return cls(items=tuple(shots[after:end]), next=more)


class SeriesReport(Schema):
    """What `measure --json` writes: a series and its fits."""

    model_config = ConfigDict(json_schema_extra=example("series_report"))

    file: str
    """Path of the recording."""
    recording: Absent[str] = None
    """Its id."""
    shots: Absent[int] = None
    """Shots on disk."""
    fit: Absent[FitReport] = None
    """The on-line fits, if they were requested."""
    value_sources: Absent[tuple[ValueSource, ...]] = None
    """Where the values of the series come from, and the limits that hold for it."""
