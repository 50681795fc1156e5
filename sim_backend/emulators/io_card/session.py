"""The cards of one lab: which have the trigger, and the shot that they play together while any card has it.

The trigger of each card is a level.
"""

from __future__ import annotations

import math

from sim_backend.world.world import World

from .board import Board
from .options import CardsOptions, LineOptions
from .shot import Shot


class Cards:
    """All cards of the lab.  Everything here happens with the world's lock held."""

    def __init__(self, world: World, options: CardsOptions) -> None:
        self.world = world
        self.options = options
        self.boards: list[Board] = []
        self.switch_override: bool | None = None
        self.cable = True
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

    def join_cable(self, joined: bool) -> None:
        """The trigger's cable from the master, which may come off."""
        with self.world.lock:
            self.cable = joined
            self.update_trigger()

    def changed(self) -> None:
        """Something that is put out changed."""
        if self.shot is not None:
            self.world.shot_simulator.replan()
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
        by_cable = self.cable and self.options.trigger_wire == "sata"
        return board.trigger_on or (by_cable and board is not master and self._propagated(board))

    def _propagated(self, board: Board) -> bool:
        before = self.boards[self.boards.index(board) - 1]
        return before.propagate and self._level(before)
