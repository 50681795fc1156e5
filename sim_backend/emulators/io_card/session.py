"""The cards of one lab and the shot they play and record together, from the first trigger to the last.

The trigger of each card is a level.  While any card has it, the world plays an open-ended shot whose drive is compiled
from the histories of the cards' registers, and anew whenever a register changes.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drivers.timeline import DigitalLine, LineLevel, SampleClock, Timeline
from sim_backend.world.shot import ShotResult
from sim_backend.world.world import World

from ..options import OUTPUTS, CardsOptions, LineOptions
from .playback import Spans, high_spans, output_bursts
from .tape import Tape

if TYPE_CHECKING:
    from .board import Board

BASE_HZ = 125e6
SHORTEST_LEG_S, USUAL_LEG_S, LONGEST_LEG_S = 0.1, 0.5, 2.0
LONGEST_LEG = 2**21
AFTER_SEQUENCE_S = 0.25


class Shot:
    """One open-ended shot: a `world.Feed`."""

    def __init__(self, cards: Cards, decimation: int, delay_samples: float) -> None:
        self._cards = cards
        self.clock = SampleClock(BASE_HZ, decimation)
        self.delay_s = delay_samples / self.clock.rate_hz
        self.tape = Tape()
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
        world.player.extend(stop)
        while not self.over:
            leg_first, result = world.player.leg()
            out = self.tape.read(first, stop)
            heard = result.heard.volts
            a, b = max(first, leg_first), min(stop, leg_first + heard.shape[1])
            if a < b and not self.over:
                out[:, a - first : b - first] = heard[:, a - leg_first : b - leg_first]
            with world.lock:
                if not self.over and world.player.leg_first() == leg_first:
                    return out
        return self.tape.read(first, stop)

    def leg_over(self, first_sample: int, result: ShotResult) -> None:
        """See Feed."""
        self.tape.add(first_sample, result)

    def timeline(self, first_sample: int, samples: int | None = None) -> Timeline:
        """See Feed."""
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
        """As long as somebody wants to read, or the sequences last, within reason; short where lines are switched by
        command, because every command changes what was computed ahead."""
        rate = self.clock.rate_hz
        options = self._cards.options
        if options.pa_gate.pin() or options.rx_connect.pin():
            return int(SHORTEST_LEG_S * rate)
        ends = [b.offset + b.sequence_stop() + AFTER_SEQUENCE_S * rate for b in self._cards.boards if b.triggered]
        # A little more than is wanted: whoever ends the shot then need not wait for another leg.
        read = self.wanted + SHORTEST_LEG_S * rate if self.wanted else 0.0
        known = read or max([e for e in ends if math.isfinite(e)], default=0.0)
        length = known - first if known > first else USUAL_LEG_S * rate
        return int(min(max(length, SHORTEST_LEG_S * rate), LONGEST_LEG_S * rate, LONGEST_LEG))

    def _bursts(self, card: Board, first: int, last: int):  # type: ignore[no-untyped-def]
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
        if not card.history:
            high = line.pin() in card.registers.pins
            return [(first, last)] if high else []
        return high_spans(card.history, line.pin(), line.pdm(), first, last)

    def _connects(self, first: int, last: int) -> Spans:
        """When the contacts are told to connect the receiver: by the card's line, or by the switch's own controller."""
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


class Cards:
    """All cards of the lab.  Everything here happens with the world's lock held."""

    def __init__(self, world: World, options: CardsOptions) -> None:
        self.world, self.options = world, options
        self.boards: list[Board] = []
        self.switch_override: bool | None = None
        self.shot: Shot | None = None

    def update_trigger(self) -> None:
        """Let every card see its trigger after a register that may change it was written."""
        with self.world.lock:
            levels = [self._level(b) for b in self.boards]
            for board, level in zip(self.boards, levels, strict=True):
                if board.triggered and not level:
                    board.trigger_fell()
            rising = [b for b, level in zip(self.boards, levels, strict=True) if level and not b.triggered]
            if rising:
                self._rise(rising)
            if self.shot is not None and not any(b.triggered for b in self.boards):
                self._end()
            elif self.shot is not None:
                self.changed()

    def changed(self) -> None:
        """Something that is put out changed."""
        if self.shot is not None:
            self.world.player.replan()
        lines = [self._idle_level(line) for line in (self.options.pa_gate, self.options.rx_connect)]
        receive = lines[1] if self.switch_override is None else self.switch_override
        self.world.idle_lines(pa_gate=lines[0], rx_connect=receive)

    def override_switch(self, receive: bool | None) -> None:
        """The switch's controller takes over (True: receive), or follows the card's line again (None)."""
        with self.world.lock:
            self.switch_override = receive
            if self.shot is not None:
                self.shot.follow.append((max(math.ceil(self.shot.now()), self.shot.follow[-1][0]), receive))
            self.changed()

    def _rise(self, rising: list[Board]) -> None:
        offset = 0 if self.shot is None else math.ceil(self.shot.now())
        for board in rising:
            board.trigger_rose(offset)
        if self.shot is None:
            first = rising[0]
            self.shot = Shot(self, first.decimation, first.filter_delay())
        for board in rising:
            board.joined(self.shot)

    def _end(self) -> None:
        assert self.shot is not None
        self.world.stop()
        self.shot.over = True
        self.shot = None
        for board in self.boards:
            board.history.clear()
        self.changed()

    def _idle_level(self, line: LineOptions) -> bool:
        return line.pin() in self.boards[line.board].registers.pins

    def _level(self, board: Board) -> bool:
        if board.held_back():
            return False
        master = self.boards[0]
        if board.trigger_mode == "EXTERNAL":
            return self.options.trigger_wire == "dio" and master.trigger_on
        through_cable = self.options.trigger_wire == "sata" and board is not master and self._propagated(board)
        return board.trigger_on or through_cable

    def _propagated(self, board: Board) -> bool:
        before = self.boards[self.boards.index(board) - 1]
        return before.propagate and self._level(before)
