"""The shot that all cards of one lab play and record together, from the first trigger to the last.

While any card has its trigger, the world plays an open-ended shot whose drive is compiled from the histories of the
cards' registers, and again whenever a register changes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from drivers.timeline import Burst, DigitalLine, LineLevel, SampleClock, Timeline
from sim_backend.world.shot import ShotResult
from sim_backend.world.world import World

from .options import OUTPUTS, BoardOptions, CardsOptions, LineOptions
from .playback import Spans, high_spans, output_bursts
from .registers import BASE_HZ, Registers
from .sample_ring import SampleRing

SHORTEST_LEG_S = 0.1
USUAL_LEG_S = 0.5
LONGEST_LEG_S = 2.0
LONGEST_LEG = 2**21
AFTER_SEQUENCE_S = 0.25


class Playing(Protocol):
    """One card, as far as its shot must know it: history holds its registers and from which sample on."""

    options: BoardOptions
    registers: Registers
    history: list[tuple[int, Registers]]
    triggered: bool
    offset: int

    def sequence_stop(self) -> float:
        """Sample after the trigger at which the running sequence ends; 0: there is none, inf: it never does."""


class Lab(Protocol):
    """All cards of a lab, as one of them or their shot sees them."""

    world: World
    options: CardsOptions
    switch_override: bool | None

    @property
    def boards(self) -> Sequence[Playing]:
        """Every card, the master first."""

    def update_trigger(self) -> None:
        """Let every card see its trigger after a register that may change it was written."""

    def changed(self) -> None:
        """Something that is put out changed."""


class Shot:
    """One open-ended shot: a `shot_simulator.SampleSource`."""

    def __init__(self, cards: Lab, decimation: int, delay_samples: float) -> None:
        self._cards = cards
        self.clock = SampleClock(BASE_HZ, decimation)
        self.delay_s = delay_samples / self.clock.rate_hz
        self.sample_ring = SampleRing()
        self.wanted = 0
        self.over = False
        self.follow: list[tuple[int, bool | None]] = [(0, cards.switch_override)]
        self.start_s = cards.world.start(self.timeline(0), self)

    def now(self) -> float:
        """Samples since the trigger."""
        return (self._cards.world.clock.monotonic_s() - self.start_s) * self.clock.rate_hz

    def volts(self, first: int, stop: int) -> NDArray[np.float32]:
        """Samples first..stop, which must have been taken already: (3, stop - first) float32, V."""
        world = self._cards.world
        world.shot_simulator.extend(stop)
        while not self.over:
            leg_first, result = world.shot_simulator.leg()
            out = self.sample_ring.read(first, stop)
            received = result.received.volts
            a, b = max(first, leg_first), min(stop, leg_first + received.shape[1])
            if a < b and not self.over:
                out[:, a - first : b - first] = received[:, a - leg_first : b - leg_first]
            with world.lock:
                if not self.over and world.shot_simulator.leg_first() == leg_first:
                    return out
        return self.sample_ring.read(first, stop)

    def leg_ended(self, first_sample: int, result: ShotResult) -> None:
        """See SampleSource."""
        self.sample_ring.add(first_sample, result)

    def timeline(self, first_sample: int, samples: int | None = None) -> Timeline:
        """See SampleSource."""
        total = self._length(first_sample) if samples is None else samples
        last = first_sample + total
        bursts = [b for card in self._cards.boards for b in self._bursts(card, first_sample, last)]
        gates = self._spans(self._cards.options.pa_gate, first_sample, last)
        connects = self._connects(first_sample, last)
        lines = [LineLevel(DigitalLine.PA_GATE, a - first_sample, b - first_sample) for a, b in gates]
        lines += [LineLevel(DigitalLine.RX_CONNECT, a - first_sample, b - first_sample) for a, b in connects]
        tx, switch = self._windows(gates, connects, first_sample, total)
        return Timeline(self.clock, tx, switch, total - tx - switch, tuple(bursts), tuple(lines))

    def _length(self, first: int) -> int:
        """As long as a client reads, or the sequences last, within limits; short where lines are switched by
        command, because every command changes what was computed ahead."""
        rate = self.clock.rate_hz
        options = self._cards.options
        if options.pa_gate.pin() or options.rx_connect.pin():
            return int(SHORTEST_LEG_S * rate)
        ends = [b.offset + b.sequence_stop() + AFTER_SEQUENCE_S * rate for b in self._cards.boards if b.triggered]
        # A little more than is read, so that the end of the shot need not wait for another leg.
        read = self.wanted + SHORTEST_LEG_S * rate if self.wanted else 0.0
        known = read or max([e for e in ends if math.isfinite(e)], default=0.0)
        length = known - first if known > first else USUAL_LEG_S * rate
        return int(min(max(length, SHORTEST_LEG_S * rate), LONGEST_LEG_S * rate, LONGEST_LEG))

    def _bursts(self, card: Playing, first: int, last: int) -> list[Burst]:
        if not card.history:
            return []
        return [
            burst
            for output, axis in enumerate(card.options.outputs)
            if axis
            for burst in output_bursts(card.history, output, OUTPUTS.index(axis), first, last, self.clock.rate_hz)
        ]

    def _spans(self, line: LineOptions, first: int, last: int) -> Spans:
        card = self._cards.boards[line.board]
        pdm = line.pdm()
        if pdm is not None and pdm >= card.options.slow_outputs:
            return []
        if not card.history:
            high = line.pin() in card.registers.pins
            return [(first, last)] if high else []
        return high_spans(card.history, line.pin(), pdm, first, last)

    def _connects(self, first: int, last: int) -> Spans:
        """Spans in which the card's line, or the switch's own controller, connects the receiver."""
        out: Spans = []
        ends = [k for k, _ in self.follow[1:]] + [last]
        for (start, override), end in zip(self.follow, ends, strict=True):
            a, b = max(start, first), min(end, last)
            if a < b and override is None:
                out += self._spans(self._cards.options.rx_connect, a, b)
            elif a < b and override:
                out.append((a, b))
        return out

    def _windows(self, gates: Spans, connects: Spans, first: int, total: int) -> tuple[int, int]:
        """TX and switch window as the world sees them: to the gate's fall, then until the contacts are quiet."""
        options = self._cards.world.options.switch
        settle = round((options.dead_time_s + options.bounce_s + options.settle_s) * self.clock.rate_hz)
        tx = min(gates[-1][1] - first, total - 1) if gates else 0
        rise = next((a - first for a, _ in connects if a - first >= tx), tx)
        return tx, max(min(rise + settle, total - 1) - tx, 0)
