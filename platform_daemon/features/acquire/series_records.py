"""A series and its shots as the store keeps them."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

import numpy as np

from drivers.calibration import ReceiveCalibration
from drivers.platform import Platform
from platform_daemon import __version__
from platform_daemon.core.hardware.shot import RawShot
from platform_daemon.core.recordings.header import SeriesHeader, ShotRecord
from platform_daemon.core.recordings.recording import RESONATOR, Excitation, FrameInfo, SequenceInfo, StepLabel
from platform_daemon.core.schemas.acquisitions import ShotReport
from sequences.compiler import ShotPlan
from sequences.request import SequenceRequest

from .planning import AcquisitionPlan


def series_header(plan: AcquisitionPlan, platform: Platform, config_text: str) -> SeriesHeader:
    """What the file of a series says of all its shots."""
    timeline, request = plan.excited.timeline, plan.request
    devices: dict[str, Any] = {
        "io_card": platform.card,
        "tx_rx_switch": platform.switch,
        "power_amplifier": platform.amplifier,
        "lna": platform.lna,
    }
    return SeriesHeader(
        sequence=SequenceInfo(
            timeline.clock.base_frequency_hz,
            timeline.clock.decimation,
            timeline.tx_samples,
            timeline.switch_samples,
            timeline.rx_samples,
        ),
        channels=platform.card.capabilities().inputs,
        start_time=platform.clock.utc().isoformat(),
        clock=platform.clock.kind,
        software_version=__version__,
        variant=plan.specimen.variant,
        calibration=store_calibration(platform),
        excitation=excitation(plan.excited, platform),
        planned_shots=len(plan.shots),
        title=f"{plan.specimen.name}, {len(plan.shots)} shots",
        sample_name=request.sample or plan.specimen.name,
        operator=request.operator,
        comment=request.comment,
        platform=platform.name,
        configuration_toml=f"{config_text}{RESONATOR}{plan.specimen_text}",
        channel_names=tuple(c.axis for c in platform.transmit),
        value_sources=plan.value_sources,
        devices={role: " ".join(asdict(d.identity()).values()).strip() for role, d in devices.items()},
    )


def header_of_shot(header: SeriesHeader, shot: ShotPlan, platform: Platform) -> SeriesHeader:
    """The header with the windows and the excitation of a shot that differs from the one before."""
    t = shot.timeline
    windows = replace(
        header.sequence, tx_samples=t.tx_samples, switch_samples=t.switch_samples, rx_samples=t.rx_samples
    )
    return replace(header, sequence=windows, excitation=excitation(shot, platform))


def store_calibration(platform: Platform) -> ReceiveCalibration:
    """The platform's calibration, receive and transmit side, as the store keeps it."""
    return replace(platform.calibration, transmit=platform.transmit_calibration)


def excitation(shot: ShotPlan, platform: Platform) -> Excitation:
    """What a shot is excited with, for the record; currents in the order of the coils."""
    currents = shot.currents_a()
    return Excitation(
        waveform=_waveform(shot.request),
        requested_hz=shot.request.f_tx_hz,
        realised_hz=shot.frequency_hz,
        field_t=0.0 if shot.blank else shot.request.field_t,
        axis=shot.request.direction(),
        periods=float(shot.request.tx_periods) if shot.lobes is None else 0.5 * len(shot.lobes),
        phase_rad=shot.request.phase_rad,
        current_a=np.array([currents.get(c.axis, 0.0) for c in platform.transmit]),
    )


def _waveform(request: SequenceRequest) -> str:
    """In words: shape and what its frequency does."""
    shape = request.waveform if request.waveform == "sine" else f"rectangle of duty {request.duty:g}"
    chirp = f", chirp of {request.chirp_hz:g} Hz" if request.chirp_hz else ""
    return shape + chirp + (", phase planned" if request.phase_plan != "none" else "")


def shot_record(
    shot: ShotPlan, raw: RawShot, late_s: float | None, step: StepLabel | None = None, *, joined: bool = False
) -> ShotRecord:
    """A shot as the store keeps it; late_s: from when it was due to its trigger; joined: the first one after a cut."""
    return ShotRecord(
        volts=raw.volts,
        time_stamp=raw.started.isoformat(),
        monotonic_s=raw.started_monotonic_s,
        late_s=late_s,
        verdict="good" if raw.reason is None else "refused",
        reason=raw.reason or "",
        temperature_c=raw.temperature_c,
        overwritten=raw.flags.overwritten,
        corrupted=raw.flags.corrupted,
        lost_steps=raw.flags.lost_steps,
        lna_overload=raw.lna_overloaded,
        amplifier_clipped=raw.amplifier_clipped,
        blank=shot.blank,
        truth=raw.truth or None,
        step=step,
        joined=joined,
    )


class Lateness:
    """now_s: of the platform's monotonic clock when the series begins, which is when its first shot is due; pause_s:
    between shots."""

    def __init__(self, now_s: float, pause_s: float) -> None:
        self._due_s, self._pause_s = now_s, pause_s

    def of(self, shot: ShotPlan, raw: RawShot) -> float:
        """s from the moment it was due to its trigger.  The next one is due a pause after its last sample."""
        late_s = raw.started_monotonic_s - self._due_s
        lasted_s = raw.volts.shape[1] / shot.timeline.clock.rate_hz
        self._due_s = raw.started_monotonic_s + lasted_s + self._pause_s
        return late_s


def shot_report(shot: ShotRecord | FrameInfo, number: int, frame: int) -> ShotReport:
    """A shot that is on disk; number: from 1; frame: in its recording, from 0."""
    return ShotReport(
        shot=number,
        frame=frame,
        time_stamp=shot.time_stamp,
        blank=shot.blank,
        verdict="good" if shot.verdict == "good" else "refused",
        reason=shot.reason or None,
        temperature_c=shot.temperature_c,
        fit=None,
    )
