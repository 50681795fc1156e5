"""Compiles a request into the timeline that the I/O card plays, and reports the realised values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from drivers.calibration import TransmitChannel
from drivers.io_card import CardCapabilities
from drivers.timeline import Burst, DigitalLine, LineLevel, Timeline
from drivers.tx_rx_switch import SwitchTiming
from sequences.bursts import lobe_bursts, sine_burst
from sequences.drive import ChannelDrive, drives_for_field
from sequences.figures import ShotFigures, figures_of
from sequences.limits import SafetyLimits, check_drive, check_figures, check_timeline
from sequences.lobes import Lobes, unplanned_lobes
from sequences.request import SequenceRequest
from sequences.windows import Windows, realise, whole_steps


@dataclass(frozen=True)
class TransmitSide:
    """The properties of the platform on which a sequence depends.

    channels: the coils; card: abilities of the I/O card; switch: timing; limits: of the site; amplifier_off_s: how long
    the amplifier may deliver power after its gate has fallen, s.
    """

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
    """A checked shot: its timeline, its drives and their effect on the coils; a blank shot has no drives.

    lobes: half periods of the field; None where it is one sine over the whole window, or blank.
    """

    request: SequenceRequest
    timeline: Timeline
    frequency_hz: float
    drives: tuple[ChannelDrive, ...]
    blank: bool
    figures: ShotFigures
    lobes: Lobes | None = None

    def currents_a(self) -> dict[str, float]:
        """Commanded coil current amplitude by axis, A."""
        return {d.channel.axis: d.current_a for d in self.drives}

    def summary(self) -> dict[str, Any]:
        """Requested and realised values for records and the dry run: plain numbers, units in the names."""
        rate = self.timeline.clock.rate_hz
        coils = self.figures.coils
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
            "peak_field_t": self.figures.peak_field_t,
            "peak_current_a": {c.axis: c.peak_a for c in coils},
            "peak_amplifier_v": {c.axis: c.peak_v for c in coils},
            "i2t_a2s": {c.axis: c.i2t_a2s for c in coils},
            "energy_j": sum(c.energy_j for c in coils),
            "heat_per_shot_j": sum(c.heat_j for c in coils),
            "duration_s": self.timeline.duration_s,
        }


def compile_shot(
    request: SequenceRequest, side: TransmitSide, *, blank: bool = False, planned: Lobes | None = None
) -> ShotPlan:
    """The checked plan of one shot.

    planned: half periods of the field, required for a request with a phase plan and forbidden for others; those that do
    not fit into the TX window are omitted.  Raises SequenceRejected if the request leaves the safety envelope, the
    card's abilities or the switch's timing.  Nothing is clamped.  A blank shot has the same windows and lines, and no
    burst.
    """
    windows = realise(request, side.card.clock, side.card.step_samples)
    drives: tuple[ChannelDrive, ...] = ()
    lobes: Lobes | None = None
    if not blank:
        drives = drives_for_field(request.field_t * request.direction(), windows.frequency_hz, side.channels)
        check_drive(request.field_t, drives, side.limits)
        lobes = _lobes(request, windows, planned, side)
    timeline = _timeline(request, windows, drives, lobes, side)
    check_timeline(timeline, side.limits, side.card, side.switch, side.amplifier_off_s)
    figures = figures_of(timeline, drives)
    check_figures(figures, drives, timeline.duration_s, side.limits)
    frequency_hz = windows.frequency_hz if planned is None or lobes is None else lobes.mean_hz()
    return ShotPlan(request, timeline, frequency_hz, drives, blank, figures, lobes)


def tx_window_s(request: SequenceRequest, side: TransmitSide) -> float:
    """Length of the TX window that a request gets, s.  Raises SequenceRejected as `compile_shot` does."""
    return realise(request, side.card.clock, side.card.step_samples).tx_samples / side.card.clock.rate_hz


def loop_lag_s(request: SequenceRequest, side: TransmitSide) -> float:
    """L/R of the loop that carries most of the current of a request, s.  Raises SequenceRejected as `compile_shot`."""
    drives = drives_for_field(request.field_t * request.direction(), request.f_tx_hz, side.channels)
    most = max(drives, key=lambda d: abs(d.current_a)).channel
    return most.inductance_h / most.resistance_ohm


def _lobes(request: SequenceRequest, windows: Windows, planned: Lobes | None, side: TransmitSide) -> Lobes | None:
    """The half periods of the field; None if the field is one plain sine."""
    if (planned is not None) != (request.phase_plan != "none"):
        raise ValueError("half periods are planned for requests with a phase plan, and for no others")
    if request.is_plain:
        return None
    tx_s = windows.tx_samples / side.card.clock.rate_hz
    return unplanned_lobes(request, windows.frequency_hz, tx_s) if planned is None else planned.until(tx_s)


def _timeline(
    request: SequenceRequest,
    windows: Windows,
    drives: Sequence[ChannelDrive],
    lobes: Lobes | None,
    side: TransmitSide,
) -> Timeline:
    """TX with the gate high, guard, receiver connected to the end."""
    total = windows.tx_samples + windows.switch_samples + windows.rx_samples
    step = side.card.step_samples
    connect = min(windows.tx_samples + whole_steps(request.guard_samples, step), total - step)
    gate = (LineLevel(DigitalLine.PA_GATE, 0, windows.tx_samples),) if drives else ()
    bursts: list[Burst] = []
    for d in drives:
        if lobes is None:
            bursts.append(sine_burst(d, windows, request.phase_rad))
        else:
            bursts += lobe_bursts(d, lobes, windows.tx_samples, side.card)
    return Timeline(
        clock=side.card.clock,
        tx_samples=windows.tx_samples,
        switch_samples=windows.switch_samples,
        rx_samples=windows.rx_samples,
        bursts=tuple(bursts),
        lines=(*gate, LineLevel(DigitalLine.RX_CONNECT, connect, total)),
    )
