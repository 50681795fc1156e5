"""Calibrations as jobs: a known dipole for the receive side, a field probe for the transmit side."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import structlog
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from drivers.errors import ConfigError, DeviceFault, InputError
from drivers.platform import Platform
from drivers.reference import FieldProbe, ReferenceDipole
from platform_daemon.calibration.phasors import Phasors, combine, segment_phasors
from platform_daemon.calibration.receive import ReceiveResult, receive_result, sensitivity_from, unlike_declared
from platform_daemon.calibration.transmit import TransmitResult, transmit_result
from platform_daemon.engine.jobs import Cancelled, Job
from platform_daemon.engine.shot import RawShot, run_shot
from platform_daemon.store import (
    Calibration,
    TransmitTable,
    add_receive_calibration,
    add_transmit_calibration,
    check_calibration_name,
)
from sequences.compiler import TransmitSide
from sequences.tones import ToneShot, coil_drive, coil_tones, dipole_shot, played_hz

log = structlog.get_logger()
AXES = ("x", "y", "z")
TRIES = 3  # per shot, if it is refused
OUTPUT_SHARE, INPUT_SHARE = 0.9, 0.4  # of full scale: on the dipole's output, and expected at the ADC
COIL_TONE_S, COIL_SEGMENTS = 0.1, 8
LOOP_TIMES = 12  # L/R: the current of a coil is in its steady state after so many
NO_PRODUCT = 2.0  # chi2 per degree of freedom from which on the model of the chain is doubted
QUESTION_STEP_S = 0.1

Hertz = Annotated[float, Field(gt=0, le=20e3, allow_inf_nan=False)]


class CalibrationRequest(BaseModel):
    """A calibration.

    kind: receive (reference dipole along x, y, z) or transmit (field probe, coil after coil); name: of the file,
    default: the kind; frequencies_hz: at least two; repetitions: shots per direction and frequency; listen_s: length of
    one (receive); amplifier_v: on the coil (transmit); temperature_span_c: it holds so far from the temperature at
    which it was made.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    kind: Literal["receive", "transmit"]
    name: Annotated[str, Field(max_length=61)] | None = None
    frequencies_hz: Annotated[tuple[Hertz, ...], Field(strict=False, min_length=2, max_length=100)] = (
        *(100.0, 212.0, 424.0, 636.0, 848.0, 1272.0),
        *(2120.0, 4000.0, 8000.0),
    )
    repetitions: Annotated[int, Field(ge=1, le=1000)] = 2
    listen_s: Annotated[float, Field(gt=0, le=60, allow_inf_nan=False)] = 0.4
    amplifier_v: Annotated[float, Field(gt=0, allow_inf_nan=False)] = 1.0
    temperature_span_c: Annotated[float, Field(gt=0, allow_inf_nan=False)] = 5.0

    @property
    def file_name(self) -> str:
        """Name of the file, without version and date."""
        return self.name or self.kind


class CalibrationWork:
    """The work of one calibration job; call it with the job.  Checked when it is made: raises InputError."""

    def __init__(self, platform: Platform, request: CalibrationRequest, side: TransmitSide, folder: Path) -> None:
        check_calibration_name(request.file_name)
        self._platform, self._request, self._side, self._folder = platform, request, side, folder
        self._frequencies = np.array(sorted({played_hz(f, side.card) for f in request.frequencies_hz}))
        if self._frequencies.size < 2:
            raise InputError("two different frequencies are needed", where="frequencies_hz", remedy="give another one")
        self._celsius: list[float] = []
        self._prepare()

    @property
    def shots(self) -> int:
        """How many shots it takes, unless some must be repeated."""
        return 3 * self._frequencies.size * self._request.repetitions

    def __call__(self, job: Job) -> None:
        """Measure, write a new version.  Raises Cancelled, DeviceError, StorageError; no file is left then."""
        raise NotImplementedError

    def _prepare(self) -> None:
        raise NotImplementedError

    def _place(self, job: Job, done: Callable[[], bool], what: str) -> None:
        """Have something brought into place; wait for the operator if nobody else does it."""
        if done():
            return
        job.ask(what)
        while not job.proceed.wait(timeout=QUESTION_STEP_S):
            if job.cancel_requested.is_set():
                raise Cancelled
        job.answered()

    def _shoot(self, job: Job, shot: ToneShot, phase: str) -> RawShot:
        """One good shot.  Raises DeviceFault if it is refused again and again."""
        job.at(job.done, phase)
        for _ in range(TRIES):
            raw = run_shot(self._platform, shot, cancelled=job.cancel_requested.is_set)
            if raw.temperature_c is not None:
                self._celsius.append(raw.temperature_c)
            if raw.reason is None:
                job.at(job.done + 1, phase)
                return raw
            job.warnings.append(f"{phase}: a shot was refused: {raw.reason}")
        remedy = "find the cause named; no calibration was written"
        raise DeviceFault(f"{TRIES} shots in a row were refused", why=str(raw.reason), remedy=remedy)

    def _temperatures(self) -> tuple[float | None, tuple[float, float] | None]:
        """Mean temperature, and between which the calibration holds."""
        if not self._celsius:
            return None, None
        span = self._request.temperature_span_c
        return float(np.mean(self._celsius)), (min(self._celsius) - span, max(self._celsius) + span)

    def _extent(self) -> tuple[float, float]:
        return float(self._frequencies[0]), float(self._frequencies[-1])


class ReceiveCalibrationWork(CalibrationWork):
    """The dipole along x, y, z, every frequency one shot: P per channel, axis and frequency."""

    def _prepare(self) -> None:
        self._dipole = _reference(self._platform)
        for f in self._frequencies:
            self._check_length(self._shot(f), f)

    def __call__(self, job: Job) -> None:
        """See CalibrationWork."""
        columns = []
        try:
            for axis in AXES:
                what = f"turn the reference dipole along {axis}, at the resonator's place"
                self._place(job, lambda axis=axis: self._dipole.turn(axis), what)  # type: ignore[misc]
                columns.append([self._column(job, axis, f) for f in self._frequencies])
        finally:
            self._dipole.remove()
        p, std = (np.array([[c[part] for c in rows] for rows in columns]).transpose(2, 0, 1) for part in (0, 1))
        self._keep(job, receive_result(self._frequencies, p, std, self._dipole.relative_std()))

    def _column(self, job: Job, axis: str, f: float) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
        """P of one axis at one frequency, (channel,), with its standard deviation."""
        shot = self._shot(f)
        heard = self._heard(job, shot, f, f"dipole along {axis}, {f:g} Hz")
        moment = self._dipole.moment_per_volt_am2(f) * shot.timeline.bursts[0].amplitude_v
        return sensitivity_from(heard.value, heard.std, moment, f)

    def _heard(self, job: Job, shot: ToneShot, f: float, phase: str) -> Phasors:
        start, rate_hz = shot.timeline.rx_start, shot.timeline.clock.rate_hz
        found = []
        for _ in range(self._request.repetitions):
            volts = self._shoot(job, shot, phase).volts[:, start:].astype(np.float64)
            if np.max(np.abs(volts)) > 0.98 * self._side.card.input_full_scale_v:
                why = "the receive side is more sensitive than the calibration in use says, or hears something else"
                raise DeviceFault(f"{phase}: the ADC clips", why=why, remedy="lower the LNA gain")
            found.append(segment_phasors(volts, f, rate_hz, start))
        return combine(np.concatenate(found))

    def _shot(self, f: float) -> ToneShot:
        """As loud as output and input allow, if the calibration in use is right to a factor of two."""
        strongest = float(np.max(np.abs(self._platform.calibration.sensitivity)))
        per_volt = 2 * np.pi * f * abs(self._dipole.moment_per_volt_am2(f)) * strongest
        can = self._side.card
        volts = min(OUTPUT_SHARE * can.output_full_scale_v, INPUT_SHARE * can.input_full_scale_v / per_volt)
        if can.output_step_v:
            volts = can.output_step_v * max(1, round(volts / can.output_step_v))
        return dipole_shot(self._dipole.output(), f, volts, self._request.listen_s, self._side)

    def _check_length(self, shot: ToneShot, f: float) -> None:
        try:
            segment_phasors(np.zeros((1, shot.timeline.rx_samples)), f, shot.timeline.clock.rate_hz)
        except ValueError as error:
            raise InputError("the shots are too short", where="listen_s", why=str(error), remedy="lengthen") from None

    def _keep(self, job: Job, found: ReceiveResult) -> None:
        made = self._platform.clock.utc()
        celsius, valid_c = self._temperatures()

        def calibration(identifier: str) -> Calibration:
            return Calibration(
                sensitivity=found.sensitivity,
                identifier=identifier,
                date=made.isoformat(),
                lna_gain=self._platform.lna.gain(),
                frequency_hz=found.frequency_hz,
                frequency_response=found.response,
                sensitivity_std=found.sensitivity_std,
                valid_hz=self._extent(),
                valid_c=valid_c,
                temperature_c=celsius,
            )

        path = add_receive_calibration(self._folder, self._request.file_name, made, calibration, found.p, found.std)
        job.warnings += unlike_declared(found.sensitivity, self._platform.calibration.sensitivity)
        if found.chi2_per_dof > NO_PRODUCT:
            job.warnings.append(
                f"calibration_response: one frequency response per channel does not explain P (chi2/dof "
                f"{found.chi2_per_dof:.2f}); the dipole may have moved"
            )
        job.result = {
            "calibration": path.stem,
            "file": path.name,
            "kind": "receive",
            "dipole": self._dipole.identity().model,
            "lna_gain": self._platform.lna.gain(),
            "frequency_hz": found.frequency_hz.tolist(),
            "p_t_per_a": {"real": found.p.real.tolist(), "imag": found.p.imag.tolist(), "std": found.std.tolist()},
            "relative_std": found.relative_std,
            "sensitivity_t_per_a": found.sensitivity.tolist(),
            "sensitivity_std_t_per_a": found.sensitivity_std.tolist(),
            "chi2_per_dof": found.chi2_per_dof,
            "date": made.isoformat(),
            "temperature_c": celsius,
            "valid_hz": list(self._extent()),
            "valid_c": None if valid_c is None else list(valid_c),
        }
        log.info("calibration_written", file=path.name)


class TransmitCalibrationWork(CalibrationWork):
    """Coil after coil, every frequency one shot, the probe at the rotor's place: field per volt."""

    def _prepare(self) -> None:
        self._probe = _field_probe(self._platform)
        for f in self._frequencies:
            for k in range(len(self._side.channels)):
                self._shot(k, f)

    @property
    def shots(self) -> int:
        """See CalibrationWork."""
        return len(self._side.channels) * self._frequencies.size * self._request.repetitions

    def __call__(self, job: Job) -> None:
        """See CalibrationWork."""
        try:
            self._place(job, self._probe.put, "put the field probe at the resonator's place, along the axes")
            coils = range(len(self._side.channels))
            found = [[self._field_per_volt(job, k, f) for f in self._frequencies] for k in coils]
        finally:
            self._probe.remove()
        value, std = (np.array([[c[part] for c in rows] for rows in found]).transpose(0, 2, 1) for part in (0, 1))
        channels = self._side.channels
        self._keep(job, transmit_result(self._frequencies, value, std, self._probe.relative_std(), channels))

    def _field_per_volt(self, job: Job, k: int, f: float) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
        """Field of coil k per volt at its DAC output, (3,), with its standard deviation."""
        channel, (shot, (first, last)) = self._side.channels[k], self._shot(k, f)
        rate_hz = shot.timeline.clock.rate_hz
        settled = first + round(LOOP_TIMES * channel.inductance_h / channel.resistance_ohm * rate_hz)
        found = []
        for _ in range(self._request.repetitions):
            self._shoot(job, shot, f"coil {channel.axis}, {f:g} Hz")
            field_t = self._probe.field_t()
            if field_t.shape != (3, shot.timeline.total_samples):
                what = f"the field probe recorded {field_t.shape} instead of (3, {shot.timeline.total_samples})"
                raise DeviceFault(what, where="field_probe", remedy="check its clock and trigger")
            heard = field_t[:, settled:last]
            found.append(segment_phasors(heard, f, rate_hz, settled - first, COIL_SEGMENTS))
        phasors = combine(np.concatenate(found))
        volts = shot.timeline.bursts[0].amplitude_v
        return phasors.value / volts, phasors.std / volts

    def _shot(self, k: int, f: float) -> tuple[ToneShot, tuple[int, int]]:
        drive = coil_drive(self._side.channels[k], self._request.amplifier_v, f)
        tone_s = min(COIL_TONE_S, 0.99 * self._side.limits.max_tx_s)
        shot, spans = coil_tones([drive], f, tone_s, self._side)
        settled_s = LOOP_TIMES * drive.channel.inductance_h / drive.channel.resistance_ohm
        if (tone_s - settled_s) / COIL_SEGMENTS * f < 1.0:
            remedy = f"choose frequencies from {1.01 * COIL_SEGMENTS / (tone_s - settled_s):.0f} Hz on"
            raise InputError(f"{f:g} Hz is too low for tones of {tone_s:g} s", where="frequencies_hz", remedy=remedy)
        return shot, spans[0]

    def _keep(self, job: Job, found: TransmitResult) -> None:
        made = self._platform.clock.utc()
        celsius, valid_c = self._temperatures()
        axes = tuple(c.axis for c in self._side.channels)

        def table(identifier: str) -> TransmitTable:
            return TransmitTable(
                axes=axes,
                identifier=identifier,
                date=made.isoformat(),
                frequency_hz=found.frequency_hz,
                field_per_volt=found.field_per_volt,
                field_per_volt_std=found.std,
                field_per_ampere_t=found.field_per_ampere_t,
                inductance_h=found.inductance_h,
                valid_hz=self._extent(),
                valid_c=valid_c,
                temperature_c=celsius,
            )

        path = add_transmit_calibration(self._folder, self._request.file_name, made, table)
        for axis, chi2 in zip(axes, found.chi2_per_dof, strict=True):
            if chi2 > NO_PRODUCT:
                job.warnings.append(
                    f"calibration_loop: resistance and inductance do not explain the field of coil {axis} (chi2/dof "
                    f"{chi2:.2f})"
                )
        value = found.field_per_volt
        job.result = {
            "calibration": path.stem,
            "file": path.name,
            "kind": "transmit",
            "probe": self._probe.identity().model,
            "coils": list(axes),
            "frequency_hz": found.frequency_hz.tolist(),
            "field_t_per_v": {"real": value.real.tolist(), "imag": value.imag.tolist(), "std": found.std.tolist()},
            "relative_std": found.relative_std,
            "field_t_per_a": found.field_per_ampere_t.tolist(),
            "inductance_h": found.inductance_h.tolist(),
            "chi2_per_dof": found.chi2_per_dof.tolist(),
            "date": made.isoformat(),
            "temperature_c": celsius,
            "valid_hz": list(self._extent()),
            "valid_c": None if valid_c is None else list(valid_c),
        }
        log.info("calibration_written", file=path.name)


def calibration_work(
    platform: Platform, request: CalibrationRequest, side: TransmitSide, folder: Path
) -> CalibrationWork:
    """The checked work of a calibration; nothing moves.  Raises InputError."""
    kinds = {"receive": ReceiveCalibrationWork, "transmit": TransmitCalibrationWork}
    return kinds[request.kind](platform, request, side, folder)


def _reference(platform: Platform) -> ReferenceDipole:
    if platform.reference is None:
        raise ConfigError(
            "the platform has no reference dipole",
            where="reference_dipole",
            remedy="describe it in the platform file, see docs/calibration.md",
        )
    return platform.reference


def _field_probe(platform: Platform) -> FieldProbe:
    if platform.probe is None:
        raise ConfigError(
            "the platform has no field probe",
            where="field_probe",
            remedy="describe it in the platform file, see docs/calibration.md",
        )
    return platform.probe
