"""The sequence of an I/O card: uploads, SEQ:SET with its traps, and the program that runs from the trigger on.

The server fills a ring of steps ahead of time and counts what it has filled.  That counter is only reset when a
sequence ends or a client connects; a SET in between fills nothing or forgets step 0, which then plays what the ring
held, enabled.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from .memory import LOOKAHEAD, RING, enable_accesses, set_accesses
from .registers import OUTPUTS, SEQUENCE_CHANNELS, Program


class ServerCrash(Exception):
    """The server's process dies."""


class State(Enum):
    """CONFIG -> SEQ:SET -> PREPARED -> trigger -> RUNNING -> CLEARING -> CONFIG.

    To a client CLEARING, in which the server empties its memory, looks as RUNNING does.
    """

    CONFIG = 0
    PREPARED = 1
    RUNNING = 2
    CLEARING = 3


@dataclass(frozen=True)
class Part:
    """A table (steps, channels) and how often it is played."""

    values: NDArray[np.float64]
    repetitions: int

    def played(self) -> NDArray[np.float64]:
        """All its steps."""
        return np.tile(self.values, (self.repetitions, 1))


@dataclass(frozen=True, eq=False)
class Tables:
    """What was uploaded for one sequence: the main table with its enable (steps, channels) and resync (steps,
    min(channels, 2)) bits, and what is played before and after."""

    main: Part | None = None
    enable: NDArray[np.bool_] | None = None
    resync: NDArray[np.bool_] | None = None
    up: Part | None = None
    down: Part | None = None


class Sequence:
    """What one board knows of its sequence.

    The server keeps two: the one that is being configured, which begins empty with the first command for it after a
    SEQ:SET, and the one that SEQ:SET has made of it.
    """

    def __init__(self) -> None:
        self.state = State.CONFIG
        self.clocks_per_step = 0
        self.channels = 0
        self.lost_steps = False
        self.program: Program | None = None
        self._next: Tables | None = None
        self._set: Tables | None = None
        self._plan: tuple[Tables, int, int, Program] | None = None
        self._freed = False
        self._filled = 0
        self._ring_first = np.zeros(SEQUENCE_CHANNELS)

    # --- uploads

    def configured(self) -> Tables:
        """The sequence that is being configured; it begins now if there is none."""
        self._next = self._next or Tables()
        return self._next

    def steps(self) -> int:
        """Steps of one repetition of the main table that is being configured, 0: there is none."""
        main = self.configured().main
        return 0 if main is None else len(main.values)

    def upload(self, values: NDArray[np.float32], repetitions: int) -> None:
        """A new main table, (steps, channels) V; discards the enable bits of the old one and keeps its resync bits."""
        main = Part(values.astype(np.float64), repetitions)
        self._next = replace(self.configured(), main=main, enable=None)

    def upload_enable(self, enable: NDArray[np.bool_]) -> None:
        """(steps, channels) of the main table."""
        self._next = replace(self.configured(), enable=enable)

    def upload_resync(self, resync: NDArray[np.bool_]) -> None:
        """(steps, min(channels, 2)) of the main table."""
        self._next = replace(self.configured(), resync=resync)

    def upload_ramp(self, values: NDArray[np.float32], repetitions: int, *, down: bool) -> None:
        """The table before or after the main one."""
        part = Part(values.astype(np.float64), repetitions)
        tables = self.configured()
        self._next = replace(tables, down=part) if down else replace(tables, up=part)

    def clear(self) -> None:
        """SEQ:CLEAR: the tables that were set are freed, the pointer to them stays."""
        self._freed = self._set is not None

    # --- life

    def set(self, samples_per_step: int) -> None:
        """SEQ:SET; nothing happens if there never was a sequence.  Raises ServerCrash after a CLEAR without a new
        one."""
        if self._next is not None:
            self._set = self._next
            self._next = None
            self._freed = False
        if self._freed:
            raise ServerCrash
        if self._set is None:
            return
        program = self._planned(self._set, samples_per_step)
        if self._filled == 0:
            self._ring_first = program.values[0].copy() if len(program.values) else np.zeros(SEQUENCE_CHANNELS)
        elif len(program.values):
            program = program.beginning_with(self._ring_first)
        self._filled = 1 if self._filled >= LOOKAHEAD else LOOKAHEAD
        self.program = program
        self.state = State.PREPARED
        self.lost_steps = False

    def let_go(self) -> None:
        """SAMPLESPERSTEP or CHAN after SEQ:SET: the server forgets that a sequence is prepared.

        Source (scpi_commands.c: seqState = CONFIG; control.c looks after a prepared or running sequence only), and seen
        on the real server: the memory stays as it is, each trigger plays it again, and it is never cleared.
        """
        if self.state is State.PREPARED and self.program is not None:
            self.program = _as_memory(self.program, self.channels)
        self.state = State.CONFIG

    def abandoned(self, elapsed: float) -> None:
        """The server's process ends `elapsed` samples after the trigger: the memory is filled no longer, and the end of
        the sequence is not noticed.

        Source (sequence_stepper.v counts modulo 8192 while the trigger is on), and seen with the compiled server.
        """
        program = self.program
        if self.state in (State.PREPARED, State.RUNNING) and program is not None and program.samples_per_step:
            self.program = _as_memory(program, self.channels, int(elapsed) // program.samples_per_step)
        self.state = State.CONFIG

    def emptied(self) -> None:
        """stopTx: a sequence that the server no longer looks after is removed from the memory as well."""
        if self.program is not None and self.program.ring:
            self.program = None

    def accesses(self) -> int:
        """What a SEQ:SET would come to now: a second one finds the ring filled and writes the enable bits only."""
        if self._next is None and self._set is None:
            return 0
        return set_accesses(self.channels) if self._filled < LOOKAHEAD else enable_accesses(self.channels)

    def started(self) -> None:
        """The trigger has come."""
        if self.state is State.PREPARED:
            self.state = State.RUNNING

    @property
    def busy(self) -> bool:
        """Whether it runs, as a client sees it."""
        return self.state in (State.RUNNING, State.CLEARING)

    def finished(self) -> None:
        """The last step is over: the server begins to clear."""
        self._emptied(0)
        self.state = State.CLEARING

    def aborted(self) -> None:
        """The trigger went before the last step was over: the ring is emptied, the counter is not."""
        self._emptied(LOOKAHEAD)
        self.state = State.CLEARING

    def cleared(self) -> None:
        """The memory is empty."""
        self.state = State.CONFIG

    def forgotten(self) -> None:
        """A client connected or disconnected: everything is reset except the uploads."""
        self._emptied(0)

    def _emptied(self, filled: int) -> None:
        self.state = State.CONFIG
        self.program = None
        self._filled = filled
        self._ring_first = np.zeros(SEQUENCE_CHANNELS)

    def _planned(self, tables: Tables, samples_per_step: int) -> Program:
        """All steps; the same program again if nothing has been uploaded since."""
        known = self._plan
        if known is None or known[0] is not tables or known[1:3] != (samples_per_step, self.channels):
            known = self._plan = tables, samples_per_step, self.channels, self._laid_out(tables, samples_per_step)
        return known[3]

    def _laid_out(self, tables: Tables, samples_per_step: int) -> Program:
        """Channels that the sequence does not have are zero and enabled."""
        parts = [
            p.played() if p is not None else np.zeros((0, self.channels)) for p in (tables.up, tables.main, tables.down)
        ]
        lengths = [len(p) for p in parts]
        total = sum(lengths)
        before = lengths[0]
        values, enable = np.zeros((total, SEQUENCE_CHANNELS)), np.ones((total, SEQUENCE_CHANNELS), dtype=np.bool_)
        resync, ramp_down = np.zeros((total, OUTPUTS), dtype=np.bool_), np.zeros(total, dtype=np.bool_)
        width = min(self.channels, SEQUENCE_CHANNELS)
        values[:, :width] = np.concatenate([p[:, :width] for p in parts])
        ramp_down[total - lengths[2] :] = True
        main = slice(before, before + lengths[1])
        if tables.main is not None and tables.enable is not None:
            enable[main, :width] = np.tile(tables.enable[:, :width], (tables.main.repetitions, 1))
        if tables.main is not None and tables.resync is not None:
            steps = len(tables.main.values)
            given = tables.resync.shape[1]
            table = np.zeros((steps, given), dtype=np.bool_)  # of a table that was shorter; the server reads beyond it
            table[: len(tables.resync)] = tables.resync[:steps]
            resync[main, :given] = np.tile(table, (tables.main.repetitions, 1))
        return Program(values, enable, resync, ramp_down, samples_per_step)


def _as_memory(program: Program, channels: int, step: int = 0) -> Program:
    """What a card steps through that its server leaves alone at a step: in the end a ring of 8192 steps.

    Beyond the sequence the server has written zeros, its channels disabled, as far as it fills ahead; what it has never
    written is zero and enabled (seen on the real server: a sine without its gate from step 7372 on).
    """
    filled = step + LOOKAHEAD
    total = max(filled, RING)
    values, enable = np.zeros((total, SEQUENCE_CHANNELS)), np.ones((total, SEQUENCE_CHANNELS), dtype=np.bool_)
    resync, ramp_down = np.zeros((total, OUTPUTS), dtype=np.bool_), np.zeros(total, dtype=np.bool_)
    steps = min(len(program.values), filled)
    values[:steps] = program.values[:steps]
    enable[:steps] = program.enable[:steps]
    resync[:steps] = program.resync[:steps]
    ramp_down[:steps] = program.ramp_down[:steps]
    enable[steps:filled, : min(channels, SEQUENCE_CHANNELS)] = False
    return Program(values, enable, resync, ramp_down, program.samples_per_step, again_from=total - RING)
