"""Calibration of the receive side as a job: a known dipole in the resonator's place gives P by frequency."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drivers.calibration import (
    MeasuredInfluence,
    ReceiveCalibration,
    angle_of,
    channel_names,
    gain_of,
    phase_of,
    turned_towards,
)
from drivers.errors import DeviceFault, InputError
from drivers.reference import FrequencyStandard
from platform_daemon.core.recordings.calibrations import add_receive_calibration
from platform_daemon.core.schemas.base import NoResult
from platform_daemon.core.schemas.calibrations import CalibrationReport, InfluenceReport, ReceiveCalibrationReport
from sequences.tones import ToneShot, dipole_shot

from .calibration_bench import DOUBTFUL_CHI2_PER_DOF, CalibrationBench, CalibrationJob, complex_table, ended, needed

if TYPE_CHECKING:
    from platform_daemon.estimation.calibration.receive import ReceiveResult

AXES = ("x", "y", "z")
CLOCK_OFF = 1e-3
"""Relative: of what is further off than this, ten times what crystals are, the clock is not the cause."""
OUTPUT_SHARE, INPUT_SHARE = 0.9, 0.4  # of full scale: on the dipole's output, and expected at the ADC


class ReceiveCalibrationWork:
    """The dipole along x, y, z, every frequency one shot: P per channel, axis and frequency."""

    kind, unit, no_result = "calibration", "shots", NoResult()

    def __init__(self, bench: CalibrationBench) -> None:
        """Raises ConfigError, InputError."""
        self._bench, self._dipole = bench, needed(bench.platform.reference, "reference dipole")
        self.request, self.total = bench.request, bench.shots(len(AXES))
        shots = [self._shot(f) for f in self._bench.frequencies_hz]
        for shot, f in zip(shots, self._bench.frequencies_hz, strict=True):
            self._check_length(shot, f)
        shots = [shot for _ in AXES for shot in shots]
        if (standard := self._dipole.standard()) is not None:
            self._check_length(self._silent_shot(standard), standard.frequency_hz)
            shots.append(self._silent_shot(standard))
            self.total += self.request.repetitions
        self.shots_s = self._bench.shots_s(shots)
        self.duration_s = sum(self.shots_s)

    def __call__(self, job: CalibrationJob) -> None:
        """Measure, write a new version.  Raises Cancelled, DeviceError, StorageError; no file is left then."""
        from platform_daemon.estimation.calibration.receive import receive_result

        columns, heard = [], []
        try:
            for axis in AXES:
                what = f"turn the reference dipole along {axis}, at the resonator's place"
                self._bench.place(job, lambda axis=axis: self._dipole.turn(axis), what)  # type: ignore[misc]
                job.expect(self.shots_s)  # the wait for a person says nothing of the pace
                shots = [self._heard(job, axis, f) for f in self._bench.frequencies_hz]
                heard.append([[part.mean(axis=0) for part in each] for each in shots])
                columns.append(
                    [self._column(each, f) for each, f in zip(shots, self._bench.frequencies_hz, strict=True)]
                )
            clock = self._clock(job)
        finally:
            self._dipole.remove()
        p, std = (np.array([[c[part] for c in rows] for rows in columns]).transpose(2, 0, 1) for part in (0, 1))
        found = receive_result(self._bench.frequencies_hz, p, std, self._dipole.relative_std())
        self._keep(job, found, (*clock, *self._influences(np.array(heard), found.sensitivity)))

    def _column(
        self, shots: list[NDArray[np.complex128]], f: float
    ) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
        """P of one axis at one frequency, (channel,), with its standard deviation."""
        from platform_daemon.estimation.calibration.phasors import combine
        from platform_daemon.estimation.calibration.receive import sensitivity_from

        shot, heard = self._shot(f), combine(np.concatenate(shots))
        moment = self._dipole.moment_per_volt_am2(f) * shot.timeline.bursts[0].amplitude_v
        return sensitivity_from(heard.value, heard.std, moment, f)

    def _clock(self, job: CalibrationJob) -> tuple[MeasuredInfluence, ...]:
        """The card's clock against the frequency standard, if there is one.  Nothing corrects for what it is off, which
        therefore counts as part of its uncertainty."""
        from platform_daemon.estimation.calibration.phasors import frequency_offset, segment_length

        standard = self._dipole.standard()
        if standard is None:
            return ()
        f = standard.frequency_hz
        what = f"feed the reference dipole from {standard.source}, {f:g} Hz"
        self._bench.place(job, self._dipole.feed_from_standard, what)
        job.expect(self.shots_s)
        shot, phase = self._silent_shot(standard), f"frequency standard, {f:g} Hz"
        timeline = shot.timeline
        segment_s = segment_length(timeline.rx_samples, f, timeline.clock.rate_hz) / timeline.clock.rate_hz
        told = [frequency_offset(part, segment_s) for part in self._played(job, shot, f, phase)]
        offset_hz = float(np.mean([hz for hz, _ in told]))
        std_hz = float(np.linalg.norm([std for _, std in told])) / len(told)
        fast, u = -offset_hz / f, float(np.hypot(std_hz / f, standard.relative_std))
        if abs(fast) > CLOCK_OFF:
            why = f"its clock would be off by {fast:.2g} of its frequency: another tone was heard, or none"
            remedy = "look whether the dipole is fed from it, and whether its frequency is the declared one"
            raise DeviceFault(f"{phase}: not heard at its frequency", why=why, remedy=remedy)
        source = f"{standard.source}: fast by {fast:.3g} with u = {u:.2g}, not corrected for"
        return (MeasuredInfluence("sample clock", float(np.hypot(fast, u)), "B", None, source),)

    def _silent_shot(self, standard: FrequencyStandard) -> ToneShot:
        """The receiver listens as long as to a tone, and the card plays none."""
        shot = dipole_shot(
            self._dipole.output(), standard.frequency_hz, 0.0, self._bench.request.listen_s, self._bench.side
        )
        return replace(shot, timeline=replace(shot.timeline, bursts=()))

    def _heard(self, job: CalibrationJob, axis: str, f: float) -> list[NDArray[np.complex128]]:
        """Phasors of one axis at one frequency: of each repetition (segment, channel)."""
        return self._played(job, self._shot(f), f, f"dipole along {axis}, {f:g} Hz")

    def _played(self, job: CalibrationJob, shot: ToneShot, f: float, phase: str) -> list[NDArray[np.complex128]]:
        from platform_daemon.estimation.calibration.phasors import segment_phasors

        start, rate_hz = shot.timeline.rx_start, shot.timeline.clock.rate_hz
        found = []
        for _ in range(self._bench.request.repetitions):
            volts = self._bench.shoot(job, shot, phase).volts[:, start:].astype(np.float64)
            if np.max(np.abs(volts)) > 0.98 * self._bench.side.card.input_full_scale_v:
                why = "the receive side is more sensitive than the calibration in use says, or hears something else"
                raise DeviceFault(f"{phase}: the ADC clips", why=why, remedy="lower the LNA gain")
            found.append(segment_phasors(volts, f, rate_hz, start))
        return found

    def _influences(
        self, heard: NDArray[np.complex128], sensitivity: NDArray[np.float64]
    ) -> tuple[MeasuredInfluence, ...]:
        """What these shots say of the channels; of the coils' angles they know as much as of the dipole's direction."""
        from platform_daemon.estimation.calibration.receive import repeatability

        found, names = [], channel_names(len(sensitivity))
        if (scatter := repeatability(heard, sensitivity)) is not None:
            source = "scatter of its repeated shots"
            for name, gain, phase in zip(names, scatter.gain.tolist(), scatter.phase_rad.tolist(), strict=True):
                found.append(MeasuredInfluence(gain_of(name), gain, "A", scatter.dof, source))
                found.append(MeasuredInfluence(phase_of(name), phase, "A", scatter.dof, source))
        if (direction := self._dipole.direction_std_rad()) is not None:
            source = "direction of its reference dipole"
            found += [
                MeasuredInfluence(angle_of(names[c], axis), direction, "B", None, source)
                for c, axis in turned_towards(sensitivity)
            ]
        return tuple(found)

    def _shot(self, f: float) -> ToneShot:
        """As loud as output and input allow, if the calibration in use is right to a factor of two."""
        strongest = float(np.max(np.abs(self._bench.platform.calibration.sensitivity)))
        per_volt = 2 * np.pi * f * abs(self._dipole.moment_per_volt_am2(f)) * strongest
        can = self._bench.side.card
        volts = min(OUTPUT_SHARE * can.output_full_scale_v, INPUT_SHARE * can.input_full_scale_v / per_volt)
        if can.output_step_v:
            volts = can.output_step_v * max(1, round(volts / can.output_step_v))
        return dipole_shot(self._dipole.output(), f, volts, self._bench.request.listen_s, self._bench.side)

    def _check_length(self, shot: ToneShot, f: float) -> None:
        from platform_daemon.estimation.calibration.phasors import segment_length

        try:
            segment_length(shot.timeline.rx_samples, f, shot.timeline.clock.rate_hz)
        except ValueError as error:
            raise InputError("the shots are too short", where="listen_s", why=str(error), remedy="lengthen") from None

    def _keep(self, job: CalibrationJob, found: ReceiveResult, influences: tuple[MeasuredInfluence, ...]) -> None:
        """Write a new version, add what to watch out for to the job's warnings, and set the job's result.

        Raises StorageError, RecordingError.
        """
        from platform_daemon.estimation.calibration.receive import unlike_declared

        made = self._bench.platform.clock.utc()
        celsius, valid_c = self._bench.temperatures_c()
        calibration = ReceiveCalibration(
            sensitivity=found.sensitivity,
            date=made.isoformat(),
            lna_gain=self._bench.platform.lna.gain(),
            frequency_hz=found.frequency_hz,
            frequency_response=found.response,
            sensitivity_std=found.sensitivity_std,
            p_std=found.std,
            relative_std=found.relative_std,
            valid_hz=self._bench.extent_hz,
            valid_c=valid_c,
            temperature_c=celsius,
            influences=influences,
        )
        path = add_receive_calibration(self._bench.folder, self._bench.request.file_name, made, calibration, found.p)
        job.warnings += unlike_declared(found.sensitivity, self._bench.platform.calibration.sensitivity)
        if found.chi2_per_dof > DOUBTFUL_CHI2_PER_DOF:
            job.warnings.append(
                f"calibration_response: one frequency response per channel does not explain P (chi2/dof "
                f"{found.chi2_per_dof:.2f}); the dipole may have moved"
            )
        report = ReceiveCalibrationReport(
            calibration=path.stem,
            file=path.name,
            kind="receive",
            dipole=self._dipole.identity().model,
            lna_gain=self._bench.platform.lna.gain(),
            frequency_hz=found.frequency_hz.tolist(),
            p_t_per_a=complex_table(found.p, found.std),
            relative_std=found.relative_std,
            sensitivity_t_per_a=found.sensitivity.tolist(),
            sensitivity_std_t_per_a=found.sensitivity_std.tolist(),
            chi2_per_dof=found.chi2_per_dof,
            date=made.isoformat(),
            temperature_c=celsius,
            valid_hz=self._bench.extent_hz,
            valid_c=valid_c,
            uncertainty=tuple(
                InfluenceReport(name=each.name, u=each.u, type=each.kind, dof=each.dof, source=each.source)
                for each in influences
            ),
        )
        ended(job, CalibrationReport(report))
