"""Lines on DIO pins, which no sequence can time: set by command, late by some ms, and it is checked how late."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from drivers.errors import ShotRefused
from drivers.red_pitaya.board import Board
from drivers.red_pitaya.layout import Layout, pin_header
from drivers.timeline import Timeline


@dataclass(order=True)
class Edge:
    """At `sample` the pin of a board goes high or low."""

    sample: int
    board: int
    pin: str
    high: bool


@dataclass
class PinLines:
    """The edges of one shot still to come; `boards` by index, empty if no line is on a DIO pin."""

    where: str
    boards: Mapping[int, Board]
    edges: Sequence[Edge]
    delay_samples: float = 0.0
    _done: int = field(init=False, default=0)

    @classmethod
    def of(cls, boards: Sequence[Board], layout: Layout, timeline: Timeline) -> PinLines:
        """The edges of a timeline's lines that are on DIO pins."""
        edges = []
        for level in timeline.lines:
            pin = layout.lines[level.line]
            if pin.sequence_channel is None:
                edges.append(Edge(level.start_sample, pin.board, pin.pin, True))
                edges.append(Edge(level.stop_sample, pin.board, pin.pin, False))
        delay = layout.pin_delay_s * layout.clock.rate_hz
        return cls(boards[0].where, dict(enumerate(boards)), sorted(edges), delay)

    def before_trigger(self) -> None:
        """Lines that are high from the first sample on."""
        while self._done < len(self.edges) and self.edges[self._done].sample == 0:
            self._set(self.edges[self._done])

    def at(self, arrived: int) -> None:
        """So many samples have arrived: set what is due.  Raises ShotRefused if it is too late for that."""
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
        """Every line low."""
        for edge in self.edges:
            if edge.high:
                self.boards[edge.board].ask(f"{pin_header(edge.pin)} OFF")

    def _set(self, edge: Edge) -> int:
        """Set the pin; returns the sample at which it was."""
        level = "ON" if edge.high else "OFF"
        _, written = self.boards[edge.board].ask(f"{pin_header(edge.pin)} {level}", "RP:ADC:WP?")
        self._done += 1
        return int(written)
