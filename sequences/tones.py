"""Timelines of calibrations and of the self-test: plain tones, on the reference dipole or on one coil at a time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from drivers.calibration import TransmitChannel
from drivers.errors import SequenceRejected
from drivers.io_card import CardCapabilities
from drivers.timeline import Burst, DigitalLine, LineLevel, Timeline
from sequences.compiler import TransmitSide
from sequences.drive import ChannelDrive
from sequences.limits import check_drive, check_timeline
from sequences.windows import whole_steps

GUARD_S = 0.5e-3  # between amplifier off and receiver on, and between the tones of a self-test
SAMPLES_PER_PERIOD = 6.0


@dataclass(frozen=True)
class ToneShot:
    """A checked shot of tones; blank: the shot needs no power, the amplifier stays disabled."""

    timeline: Timeline
    blank: bool


def played_hz(frequency_hz: float, card: CardCapabilities) -> float:
    """The frequency that the card plays for a requested one, Hz.  Raises SequenceRejected if there is none."""
    step = card.frequency_step_hz
    played = step * round(frequency_hz / step) if step else frequency_hz
    if not 0 < played <= card.clock.rate_hz / SAMPLES_PER_PERIOD:
        raise SequenceRejected(
            f"a tone of {frequency_hz:g} Hz cannot be measured",
            where="frequency_hz",
            remedy=f"choose frequencies up to {card.clock.rate_hz / SAMPLES_PER_PERIOD:.0f} Hz",
        )
    return played


def dipole_shot(output: int, frequency_hz: float, volts: float, listen_s: float, side: TransmitSide) -> ToneShot:
    """A tone on the reference dipole's output, from the first sample to the last, received by the connected receiver.

    The gate stays low throughout.  Raises SequenceRejected if the card cannot play it.
    """
    _has_output(output, side.card)
    rate_hz, step = side.card.clock.rate_hz, side.card.step_samples
    before = whole_steps(side.switch.total_s * rate_hz + side.card.line_delay_s * rate_hz + 1, step)
    rx = whole_steps(listen_s * rate_hz, step)
    timeline = Timeline(
        clock=side.card.clock,
        tx_samples=0,
        switch_samples=before,
        rx_samples=rx,
        bursts=(Burst(output, 0, before + rx, frequency_hz, volts),),
        lines=(LineLevel(DigitalLine.RX_CONNECT, 0, before + rx),),
    )
    if any(c.output == output for c in side.channels):
        why = "the receiver would be connected to a driven coil"
        raise SequenceRejected(f"a coil hangs on output {output}", why=why, remedy="correct reference_dipole.output")
    check_timeline(replace(timeline, bursts=()), side.limits, side.card, side.switch, side.amplifier_off_s)
    return ToneShot(timeline, blank=True)


def coil_tones(
    drives: Sequence[ChannelDrive], frequency_hz: float, tone_s: float, side: TransmitSide
) -> tuple[ToneShot, list[tuple[int, int]]]:
    """A tone on one coil after the other, each for `tone_s`, then the receiver; and first and last sample of each tone.

    Raises SequenceRejected outside the safety envelope.
    """
    rate_hz, step = side.card.clock.rate_hz, side.card.step_samples
    tone, gap = whole_steps(tone_s * rate_hz, step), whole_steps(_guard_s(side) * rate_hz, step)
    spans = [(k * (tone + gap), k * (tone + gap) + tone) for k in range(len(drives))]
    tx = spans[-1][1]
    before = whole_steps((side.switch.total_s + _guard_s(side) + side.card.line_delay_s) * rate_hz + 1, step) + step
    total = max(tx + before + step, whole_steps(1.01 * tx / side.limits.max_tx_duty, step))
    bursts = [
        Burst(d.channel.output, first, last, frequency_hz, d.dac_v, 0.0)
        for d, (first, last) in zip(drives, spans, strict=True)
    ]
    for each in drives:
        field_t = abs(each.current_a) * float(np.linalg.norm(each.channel.field_per_ampere_t))
        check_drive(field_t, (each,), side.limits)
    timeline = Timeline(
        clock=side.card.clock,
        tx_samples=tx,
        switch_samples=before,
        rx_samples=total - tx - before,
        bursts=tuple(bursts),
        lines=(LineLevel(DigitalLine.PA_GATE, 0, tx), LineLevel(DigitalLine.RX_CONNECT, tx + gap, total)),
    )
    check_timeline(timeline, side.limits, side.card, side.switch, side.amplifier_off_s)
    return ToneShot(timeline, blank=False), spans


def coil_drive(channel: TransmitChannel, amplifier_v: float, frequency_hz: float) -> ChannelDrive:
    """The drive of one coil with a voltage amplitude after the amplifier, phase 0 at the DAC."""
    current_a = amplifier_v / abs(channel.impedance_ohm(frequency_hz))
    return ChannelDrive(channel, current_a, amplifier_v, amplifier_v / channel.amplifier_gain, 0.0)


def _has_output(output: int, card: CardCapabilities) -> None:
    if not 0 <= output < card.outputs:
        raise SequenceRejected(
            f"the card has no output {output} for the reference dipole",
            where="reference_dipole.output",
            why=f"its {card.outputs} outputs count from 0",
            remedy="add the output to the card's table in the platform file",
        )


def _guard_s(side: TransmitSide) -> float:
    """Time from the gate's fall to the receiver, s; it exceeds the least guard by at least half a step."""
    return max(GUARD_S, side.guard_s + side.card.step_samples / side.card.clock.rate_hz + side.card.line_delay_s)
