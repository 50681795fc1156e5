"""Compiles a request into the timeline that the I/O card plays, and says what was realised of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drivers.calibration import TransmitChannel
from drivers.io_card import CardCapabilities
from drivers.timeline import Burst, DigitalLine, LineLevel, Timeline
from drivers.tx_rx_switch import SwitchTiming
from sequences.drive import ChannelDrive, drives_for_field
from sequences.limits import SafetyLimits, check_drive, check_timeline
from sequences.request import SequenceRequest
from sequences.windows import Windows, realise, whole_steps


@dataclass(frozen=True)
class TransmitSide:
    """What a sequence must know of the platform: coils, card, switch, the site's limits, and how long
    the amplifier may put out power after its gate has fallen, s."""

    channels: Sequence[TransmitChannel]
    card: CardCapabilities
    switch: SwitchTiming
    limits: SafetyLimits
    amplifier_off_s: float = 0.0

    @property
    def guard_s(self) -> float:
        """Least time from the end of the gate to the receiver's connection, s; what late lines need comes on top."""
        return max(self.limits.min_guard_s, self.amplifier_off_s)


@dataclass(frozen=True)
class ShotPlan:
    """A checked shot: its timeline and its drives; a blank shot has none."""

    request: SequenceRequest
    timeline: Timeline
    frequency_hz: float
    drives: tuple[ChannelDrive, ...]
    blank: bool

    def currents_a(self) -> dict[str, float]:
        """Commanded coil current amplitude by axis, A."""
        return {d.channel.axis: d.current_a for d in self.drives}

    def summary(self) -> dict[str, float | int | bool | dict[str, float]]:
        """Requested and realised values, plain numbers with units in the names, for records and the dry run."""
        rate = self.timeline.clock.rate_hz
        heat = sum(0.5 * d.current_a**2 * d.channel.resistance_ohm for d in self.drives)
        return {
            "blank": self.blank,
            "f_tx_requested_hz": self.request.f_tx_hz,
            "f_tx_realised_hz": self.frequency_hz,
            "field_t": 0.0 if self.blank else self.request.field_t,
            "tx_periods": self.request.tx_periods,
            "tx_samples": self.timeline.tx_samples,
            "switch_samples": self.timeline.switch_samples,
            "rx_samples": self.timeline.rx_samples,
            "t_tx_s": self.timeline.tx_samples / rate,
            "t_switch_s": self.timeline.switch_samples / rate,
            "t_rx_s": self.timeline.rx_samples / rate,
            "coil_current_a": self.currents_a(),
            "amplifier_v": {d.channel.axis: d.amplifier_v for d in self.drives},
            "heat_per_shot_j": heat * self.timeline.tx_samples / rate,
            "duration_s": self.timeline.duration_s,
        }


def compile_shot(request: SequenceRequest, side: TransmitSide, *, blank: bool = False) -> ShotPlan:
    """The checked plan of one shot.

    Raises SequenceRejected if the request leaves the safety envelope, the card's abilities or the switch's timing.
    Nothing is clamped.  A blank shot has the same windows and lines, and no burst.
    """
    windows = realise(request, side.card.clock, side.card.step_samples)
    drives: tuple[ChannelDrive, ...] = ()
    if not blank:
        drives = drives_for_field(request.field_t * request.direction(), windows.frequency_hz, side.channels)
        check_drive(request.field_t, drives, side.limits)
    timeline = _timeline(request, windows, drives, side)
    check_timeline(timeline, side.limits, side.card, side.switch, side.amplifier_off_s)
    return ShotPlan(request, timeline, windows.frequency_hz, drives, blank)


def _timeline(
    request: SequenceRequest, windows: Windows, drives: Sequence[ChannelDrive], side: TransmitSide
) -> Timeline:
    """TX with the gate high, guard, receiver connected to the end."""
    total = windows.tx_samples + windows.switch_samples + windows.rx_samples
    step = side.card.step_samples
    connect = min(windows.tx_samples + whole_steps(request.guard_samples, step), total - step)
    gate = (LineLevel(DigitalLine.PA_GATE, 0, windows.tx_samples),) if drives else ()
    return Timeline(
        clock=side.card.clock,
        tx_samples=windows.tx_samples,
        switch_samples=windows.switch_samples,
        rx_samples=windows.rx_samples,
        bursts=tuple(_burst(d, windows) for d in drives),
        lines=(*gate, LineLevel(DigitalLine.RX_CONNECT, connect, total)),
    )


def _burst(drive: ChannelDrive, windows: Windows) -> Burst:
    phase = float(np.mod(drive.phase_rad, 2 * np.pi))
    return Burst(drive.channel.output, 0, windows.tx_samples, windows.frequency_hz, drive.dac_v, phase)
