"""Lines on DIO pins, which no sequence can time: the host sets them some ms late, and checks how late."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from drivers.errors import DeviceTimeout, ShotRefused
from drivers.red_pitaya.board import Board
from drivers.red_pitaya.gate_clock import GateClock
from drivers.red_pitaya.layout import Layout, LinePin, pin_header
from drivers.red_pitaya.pins import level, set_pin
from drivers.red_pitaya.reply_deadline import ReplyDeadline
from drivers.timeline import DigitalLine, Timeline

GATE_GRACE_S = 0.25  # the end of a gate that is set by command may be late by `pin_delay_s` and this
TRIES = 3  # answers whose slowest says how late a line would be


@dataclass(order=True)
class Edge:
    """At `sample` the pin of a board goes high or low."""

    sample: int
    board: int
    pin: str
    high: bool
    line: DigitalLine


@dataclass(kw_only=True)
class PinLines:
    """The edges of one shot still to come; `boards` by index, empty if no line is on a DIO pin."""

    where: str
    boards: Mapping[int, Board]
    edges: Sequence[Edge]
    delay_samples: float = 0.0
    rate_hz: float = 1.0
    gate: LinePin | None = None
    _done: int = field(init=False, default=0)
    _clock: GateClock | None = field(init=False, default=None)

    @classmethod
    def of(cls, boards: Sequence[Board], layout: Layout, timeline: Timeline) -> PinLines:
        """The edges of a timeline's lines that are on DIO pins."""
        edges = []
        for high in timeline.lines:
            pin = layout.lines[high.line]
            if pin.sequence_channel is None:
                edges.append(Edge(high.start_sample, pin.board, pin.pin, True, high.line))
                edges.append(Edge(high.stop_sample, pin.board, pin.pin, False, high.line))
        rate_hz = layout.clock.rate_hz
        gate = layout.lines[DigitalLine.PA_GATE]
        return cls(
            where=boards[0].where,
            boards=dict(enumerate(boards)),
            edges=sorted(edges),
            delay_samples=layout.pin_delay_s * rate_hz,
            rate_hz=rate_hz,
            gate=gate,
        )

    def check_pace(self, chunk_samples: int) -> None:
        """Before power: check that a line could be set in time.  Raises DeviceTimeout if the card is too slow."""
        if not self.edges:
            return
        slowest_s = max(self._round_trip_s(board) for board in self.boards.values() for _ in range(TRIES))
        late = chunk_samples + 2 * slowest_s * self.rate_hz
        if late > self.delay_samples:
            raise DeviceTimeout(
                f"a line on a DIO pin would be {late / self.rate_hz:.3f} s late",
                where=self.where,
                why=f"the card answered after {slowest_s:.3f} s, and io_card.pin_delay_s allows "
                f"{self.delay_samples / self.rate_hz:.3f} s",
                remedy="repeat the shot; if it happens again, put the lines on AO0 ... AO2, which the card times",
            )

    def before_trigger(self) -> None:
        """Set the lines that are high from the first sample on."""
        while self._done < len(self.edges) and self.edges[self._done].sample == 0:
            self._set(self.edges[self._done])

    def at(self, arrived: int) -> None:
        """Set the lines that are due after `arrived` samples.  Raises ShotRefused if it is too late for that."""
        self.check()
        while self._done < len(self.edges) and self.edges[self._done].sample <= arrived:
            edge = self.edges[self._done]
            written = self._set(edge)
            if written - edge.sample > self.delay_samples:
                raise ShotRefused(
                    f"a line on {edge.pin} was set {written - edge.sample} samples late",
                    where=self.where,
                    why=f"io_card.pin_delay_s allows {self.delay_samples:.0f}",
                )

    def low(self) -> None:
        """Set every line low."""
        for edge in self.edges:
            if edge.high:
                self.boards[edge.board].ask(f"{pin_header(edge.pin)} OFF")

    def _set(self, edge: Edge) -> int:
        """Set the pin; returns the sample at which it was.

        The receiver is connected only if the gate reads back low at its pad, whatever was commanded.  Raises
        ShotRefused if the gate is still high then, or if a pin does not follow.
        """
        if edge.line is DigitalLine.RX_CONNECT and edge.high and self._gate_is_high():
            raise ShotRefused(
                "the amplifier's gate still reads back high, so the receiver stays disconnected", where=self.where
            )
        gate = edge.line is DigitalLine.PA_GATE
        if gate and edge.high:
            self._set_reply_deadline(edge)
        found, written = set_pin(self.boards[edge.board].ask, edge.pin, high=edge.high)
        if found != level(edge.high):
            raise ShotRefused(f"{edge.pin} was set {level(edge.high)} and reads back {found}", where=self.where)
        if gate and not edge.high:
            self._set_reply_deadline(None)
        self._done += 1
        return written

    def check(self) -> None:
        """Raises ShotRefused if the timer had to lower the gate."""
        if self._clock is not None:
            self._clock.check(self.where)

    def _set_reply_deadline(self, rises: Edge | None) -> None:
        """While a command keeps the gate high, limit all waiting together to how late its end may be.

        At that time a timer lowers the gate, whichever thread waits.
        """
        reply_deadline = None
        if rises is not None:
            timeout_s = self.delay_samples / self.rate_hz + GATE_GRACE_S
            end = next(e.sample for e in self.edges[self._done :] if e.line is rises.line and not e.high)
            gate_s = (end - rises.sample) / self.rate_hz
            reply_deadline = ReplyDeadline(timeout_s, deadline_s=time.monotonic() + gate_s + timeout_s)
            self._clock = GateClock(reply_deadline.deadline_s, self.boards[rises.board].low([rises.pin]))
        elif self._clock is not None:
            self._clock.stop(self.where)
        for board in self.boards.values():
            board.reply_deadline = reply_deadline

    def _gate_is_high(self) -> bool:
        assert self.gate is not None
        return self.boards[self.gate.board].ask(f"{pin_header(self.gate.pin)}?")[0] != "OFF"

    def _round_trip_s(self, board: Board) -> float:
        begun_s = time.monotonic()
        board.ask("RP:ADC:WP?")
        return time.monotonic() - begun_s
