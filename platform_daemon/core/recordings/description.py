"""What a recording holds, as `info` and REST show it."""

from __future__ import annotations

from collections.abc import Sequence

from drivers.calibration import ReceiveCalibration
from platform_daemon.core.schemas.recordings import (
    AngleInfo,
    CalibrationInfo,
    ExcitationInfo,
    FrameDescription,
    FrequencyResponseExtent,
    RecordingInfo,
    ShotWindows,
    TableColumn,
    WindowLength,
)

from .angle_series import AngleSeries
from .column_file import finite_range
from .recording import Excitation, Recording


def describe(recording: Recording, listed: range | None = None) -> RecordingInfo:
    """Summary of a recording; None where the file does not say.  Reads no volts.

    listed: frames that are described each for itself, as far as there are that many; None: all.
    """
    frames = range(recording.frames)
    if listed is not None:
        frames = frames[listed.start : listed.stop]
    p, s = recording.provenance, recording.sequence

    def window(samples: int) -> WindowLength:
        return WindowLength(samples=samples, seconds=samples / s.rate_hz)

    return RecordingInfo(
        file=str(recording.path),
        size_bytes=recording.size_bytes,
        layout="own" if p else "minimal",
        variant=recording.variant,
        frames=recording.frames,
        good=sum(info.verdict == "good" for info in recording.frame_info),
        channels=recording.channels,
        channel_names=p.channel_names if p else (),
        rate_hz=s.rate_hz,
        base_frequency_hz=s.base_frequency_hz,
        decimation=s.decimation,
        windows=ShotWindows(tx=window(s.tx_samples), switch=window(s.switch_samples), rx=window(s.rx_samples)),
        calibration=_calibration(recording.calibration),
        incomplete=p.incomplete if p else None,
        sample=p.sample_name if p else None,
        operator=p.operator if p else None,
        comment=p.comment if p else None,
        title=p.title if p else None,
        start_time=p.start_time if p else None,
        clock=p.clock if p else None,
        platform=p.platform if p else None,
        devices=dict(p.devices) if p else {},
        software_version=p.software_version if p else None,
        fits=tuple(recording.fits),
        value_sources=(p.value_sources or None) if p else None,
        shots=tuple(_shot(recording, k) for k in frames) if p else (),
    )


def _shot(recording: Recording, k: int) -> FrameDescription:
    info = recording.frame_info[k]
    return FrameDescription(
        frame=k,
        shot=info.shot,
        time_stamp=info.time_stamp,
        temperature_c=info.temperature_c,
        late_s=info.late_s,
        verdict=info.verdict,
        reason=info.reason,
        flags=tuple(info.flags),
        valid_samples=info.valid_samples,
        blank=info.blank,
        excitation=_excitation(info.excitation),
        step=None if info.step is None else info.step.label.number,
        step_name=None if info.step is None else info.step.label.name or None,
        values=None if info.step is None else dict(info.step.label.values),
        joined=info.joined or None,
    )


def _excitation(excitation: Excitation | None) -> ExcitationInfo | None:
    if excitation is None:
        return None
    return ExcitationInfo(
        waveform=excitation.waveform,
        requested_hz=excitation.requested_hz,
        realised_hz=excitation.realised_hz,
        field_t=excitation.field_t,
        axis=tuple(map(float, excitation.axis)),
        periods=excitation.periods,
        phase_rad=excitation.phase_rad,
        current_a=tuple(map(float, excitation.current_a)),
    )


def _calibration(calibration: ReceiveCalibration | None) -> CalibrationInfo | None:
    if calibration is None:
        return None
    f = calibration.frequency_hz
    known = None
    if f is not None:
        known = FrequencyResponseExtent(points=len(f), from_hz=float(f[0]), to_hz=float(f[-1]))
    return CalibrationInfo(
        id=calibration.identifier,
        date=calibration.date,
        lna_gain=calibration.lna_gain,
        sensitivity=calibration.sensitivity.tolist(),
        sensitivity_std=None if calibration.sensitivity_std is None else calibration.sensitivity_std.tolist(),
        relative_std=calibration.relative_std,
        valid_hz=calibration.valid_hz,
        valid_c=calibration.valid_c,
        temperature_c=calibration.temperature_c,
        transmit=None if calibration.transmit is None else calibration.transmit.identifier,
        response=known,
    )


def describe_angle(series: AngleSeries, size_bytes: int, columns: Sequence[TableColumn] = ()) -> AngleInfo:
    """Summary of an angle series; size_bytes: of its file; columns: of a table."""
    lowest, highest = finite_range(series.angle_rad)
    return AngleInfo(
        file=str(series.path),
        size_bytes=size_bytes,
        columns=tuple(columns),
        samples=series.angle_rad.shape[1],
        rate_hz=series.sampling_rate_hz,
        lowest_rad=lowest,
        highest_rad=highest,
        notes=(*series.clock, *series.done),
    )
