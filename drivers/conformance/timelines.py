"""Short timelines for any card."""

from __future__ import annotations

from drivers.io_card import CardCapabilities, Chunk, IoCard
from drivers.timeline import Burst, DigitalLine, LineLevel, Timeline

TX_S = 0.01
GAP_S = 0.07
RX_S = 0.1
WHISPER = 1e-3  # of the output's full scale


def short_shot(can: CardCapabilities, *, bursts: bool = True, rx_s: float = RX_S) -> Timeline:
    """A burst on every output under the gate, then a gap long enough for any switch and any late line, then RX."""
    rate_hz = can.clock.rate_hz
    tx, gap, rx = (steps(seconds * rate_hz, can) for seconds in (TX_S, GAP_S + 2 * can.line_delay_s, rx_s))
    total = tx + gap + rx
    connect = tx + steps((0.001 + can.line_delay_s) * rate_hz, can)
    volts = WHISPER * can.output_full_scale_v
    sines = tuple(Burst(k, 0, tx, 10 * rate_hz / tx, volts) for k in range(can.outputs)) if bursts else ()
    gate = (LineLevel(DigitalLine.PA_GATE, 0, tx),) if bursts else ()
    return Timeline(can.clock, tx, gap, rx, sines, (*gate, LineLevel(DigitalLine.RX_CONNECT, connect, total)))


def steps(samples: float, can: CardCapabilities) -> int:
    """Samples as whole steps of the card, at least one."""
    return max(1, round(samples / can.step_samples)) * can.step_samples


def collect(card: IoCard, timeline: Timeline, most: int) -> list[Chunk]:
    """A whole shot, in reads of at most so many samples."""
    card.program(timeline)
    card.arm()
    card.trigger()
    chunks: list[Chunk] = []
    while sum(c.volts.shape[1] for c in chunks) < timeline.total_samples:
        chunks.append(card.read(most))
    return chunks
