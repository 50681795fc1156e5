"""Calibration of the transmit side as a job: a field probe in the rotor's place gives the field per volt of a coil."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drivers.calibration import TransmitCalibration
from drivers.errors import DeviceFault, InputError
from platform_daemon.core.hardware.calibration_in_use import ChainTest
from platform_daemon.core.recordings.calibrations import add_transmit_calibration
from platform_daemon.core.schemas.base import NoResult
from platform_daemon.core.schemas.calibrations import CalibrationReport, TransmitCalibrationReport
from sequences.tones import ToneShot, coil_drive, coil_tones

from .calibration_bench import DOUBTFUL_CHI2_PER_DOF, CalibrationBench, CalibrationJob, complex_table, ended, needed

if TYPE_CHECKING:
    from platform_daemon.estimation.calibration.transmit import TransmitResult

COIL_TONE_S, COIL_SEGMENTS = 0.1, 8
LOOP_TIMES = 12  # L/R: the current of a coil is in its steady state after so many


class TransmitCalibrationWork:
    """Coil after coil, every frequency one shot, the probe at the rotor's place: field per volt.  The self-test comes
    first: these shots put power out."""

    kind, unit, no_result = "calibration", "shots", NoResult()

    def __init__(self, bench: CalibrationBench, chain_test: ChainTest) -> None:
        """Raises ConfigError, InputError."""
        self._bench, self._probe, self._chain_test = bench, needed(bench.platform.probe, "field probe"), chain_test
        self.request, self.total = bench.request, bench.shots(len(bench.side.channels))
        coils = range(len(self._bench.side.channels))
        self.shots_s = self._bench.shots_s([self._shot(k, f)[0] for k in coils for f in self._bench.frequencies_hz])
        self.duration_s = sum(self.shots_s)

    def __call__(self, job: CalibrationJob) -> None:
        """Measure, write a new version.  Raises Cancelled, DeviceFault, DeviceError, StorageError; no file is left
        then."""
        from platform_daemon.estimation.calibration.transmit import transmit_result

        if self._chain_test.enabled:
            job.at(0, "self-test")
            self._chain_test(job.cancel_requested.is_set)
        try:
            self._bench.place(job, self._probe.put, "put the field probe at the resonator's place, along the axes")
            job.expect(self.shots_s)  # the wait for a person says nothing of the pace
            coils = range(len(self._bench.side.channels))
            found = [[self._field_per_volt(job, k, f) for f in self._bench.frequencies_hz] for k in coils]
        finally:
            self._probe.remove()
        value, std = (np.array([[c[part] for c in rows] for rows in found]).transpose(0, 2, 1) for part in (0, 1))
        channels = self._bench.side.channels
        self._keep(
            job,
            transmit_result(self._bench.frequencies_hz, value, std, self._probe.relative_std(), channels),
        )

    def _field_per_volt(
        self, job: CalibrationJob, k: int, f: float
    ) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
        """Field of coil k per volt at its DAC output, (3,), with its standard deviation."""
        from platform_daemon.estimation.calibration.phasors import combine, segment_phasors

        channel, (shot, (first, last)) = self._bench.side.channels[k], self._shot(k, f)
        rate_hz = shot.timeline.clock.rate_hz
        settled = first + round(LOOP_TIMES * channel.inductance_h / channel.resistance_ohm * rate_hz)
        found = []
        for _ in range(self._bench.request.repetitions):
            self._bench.shoot(job, shot, f"coil {channel.axis}, {f:g} Hz")
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
        drive = coil_drive(self._bench.side.channels[k], self._bench.request.amplifier_v, f)
        tone_s = min(COIL_TONE_S, 0.99 * self._bench.side.limits.max_tx_s)
        shot, spans = coil_tones([drive], f, tone_s, self._bench.side)
        settled_s = LOOP_TIMES * drive.channel.inductance_h / drive.channel.resistance_ohm
        if (tone_s - settled_s) / COIL_SEGMENTS * f < 1.0:
            remedy = f"choose frequencies from {1.01 * COIL_SEGMENTS / (tone_s - settled_s):.0f} Hz on"
            raise InputError(f"{f:g} Hz is too low for tones of {tone_s:g} s", where="frequencies_hz", remedy=remedy)
        return shot, spans[0]

    def _keep(self, job: CalibrationJob, found: TransmitResult) -> None:
        made = self._bench.platform.clock.utc()
        celsius, valid_c = self._bench.temperatures_c()
        axes = tuple(c.axis for c in self._bench.side.channels)
        calibration = TransmitCalibration(
            axes=axes,
            identifier="",  # that of its version
            date=made.isoformat(),
            frequency_hz=found.frequency_hz,
            field_per_volt=found.field_per_volt,
            field_per_volt_std=found.std,
            field_per_ampere_t=found.field_per_ampere_t,
            inductance_h=found.inductance_h,
            valid_hz=self._bench.extent_hz,
            valid_c=valid_c,
            temperature_c=celsius,
        )
        path = add_transmit_calibration(self._bench.folder, self._bench.request.file_name, made, calibration)
        for axis, chi2 in zip(axes, found.chi2_per_dof, strict=True):
            if chi2 > DOUBTFUL_CHI2_PER_DOF:
                job.warnings.append(
                    f"calibration_loop: resistance and inductance do not explain the field of coil {axis} (chi2/dof "
                    f"{chi2:.2f})"
                )
        report = TransmitCalibrationReport(
            calibration=path.stem,
            file=path.name,
            kind="transmit",
            probe=self._probe.identity().model,
            coils=axes,
            frequency_hz=found.frequency_hz.tolist(),
            field_t_per_v=complex_table(found.field_per_volt, found.std),
            relative_std=found.relative_std,
            field_t_per_a=found.field_per_ampere_t.tolist(),
            inductance_h=found.inductance_h.tolist(),
            chi2_per_dof=found.chi2_per_dof.tolist(),
            date=made.isoformat(),
            temperature_c=celsius,
            valid_hz=self._bench.extent_hz,
            valid_c=valid_c,
        )
        ended(job, CalibrationReport(report))
