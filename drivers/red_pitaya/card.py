"""One or several boards as one I/O card.

A shot: `program` uploads the sequences (once per timeline), `arm` sets them and the amplitudes, `trigger` starts the
master and asks every board for the whole recording, `read` takes chunk after chunk from all of them.  A shot that runs
to its end leaves the boards ready for the next.  One that does not is ended by a new connection, which zeroes all
outputs at once and is the only safe way out of an unfinished sequence.
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Iterator
from typing import TextIO

from drivers.errors import DeviceError, InputError, PlatformError
from drivers.identity import Identity
from drivers.io_card import CardCapabilities, CardState, Chunk, require, was_stopped
from drivers.red_pitaya import trigger
from drivers.red_pitaya.board import Board, arm_all, emergency_stop
from drivers.red_pitaya.boards import connect_all, failures_of
from drivers.red_pitaya.layout import pin_header
from drivers.red_pitaya.lines import PinLines
from drivers.red_pitaya.lock import lock_card, note_recording
from drivers.red_pitaya.options import CardTable
from drivers.red_pitaya.pins import level, set_pin
from drivers.red_pitaya.reader import Reader
from drivers.red_pitaya.scale import Scale
from drivers.red_pitaya.sequence import MAX_SAMPLES, OUTPUT_FULL_SCALE_V, BoardProgram, compile_timeline
from drivers.red_pitaya.sines import AMPLITUDE_STEP_V
from drivers.red_pitaya.stream import filter_delay_samples
from drivers.timeline import Timeline

WHERE = "I/O card"
FREQUENCY_STEP_HZ = 125e6 / 2**48
PIN_CHUNK = 320  # samples per chunk where lines are set by command, which waits for the end of a chunk
PATIENCE_S = 0.2  # how long a stop waits for commands that are on their way
START_S = 0.1  # how long the server may take to see that a sequence plays
GRANULE = 32  # the recording grows in steps of so many samples


class RedPitayaCard:
    """See drivers.io_card.IoCard."""

    def __init__(self, table: CardTable) -> None:
        """Open all boards; outputs are off when it returns.

        Raises ConfigError, DeviceNotFound, DeviceTimeout, DeviceProtocolError, DeviceDenied if another daemon holds
        a board.
        """
        self._table, self.layout = table, table.layout()
        self._delay = round(filter_delay_samples(table.decimation))
        self._start_samples = round(START_S * self.layout.clock.rate_hz)
        last = len(table.boards) - 1
        lines = [(p.board, p.pin) for p in self.layout.lines.values() if p.sequence_channel is None]
        self.boards = [
            Board(address, table, [pin for board, pin in lines if board == k], is_last=k == last)
            for k, address in enumerate(table.boards)
        ]
        self._locks: list[TextIO] = []
        self._guard = threading.RLock()  # whoever gives commands; never held while waiting for samples
        self._stopping = threading.Lock()
        self._stops = 0
        self._state = CardState.IDLE
        self._timeline: Timeline | None = None
        self._programs: tuple[BoardProgram, ...] = ()
        self._asked: tuple[Timeline, float] | None = None  # what they were compiled from, for the next shot
        self._reader = Reader(self.boards, (), 0, 0, 1)
        self._pins = PinLines(self.boards[0].where, {}, ())
        try:
            for board in self.boards:
                self._locks.append(lock_card(board.address.host, board.address.command_port))
            connect_all(self.boards, self._locks)
            if table.prove_wiring:
                trigger.prove(self.boards)
        except Exception:
            self._let_go()
            raise

    def identity(self) -> Identity:
        """See IoCard.  The serial number is the address: the server tells none."""
        for board in self.boards:
            board.ask("RP:MODE?")
        where = ", ".join(board.address.host for board in self.boards)
        versions = "; ".join(dict.fromkeys(board.version for board in self.boards))
        return Identity("Red Pitaya", f"{len(self.boards)} x STEMlab 125-14, RedPitayaDAQServer", where, versions)

    def capabilities(self) -> CardCapabilities:
        """See IoCard."""
        boards = list(zip(self.boards, self.layout.boards, strict=True))
        return CardCapabilities(
            inputs=self.layout.inputs,
            outputs=self.layout.outputs,
            input_full_scale_v=min(b.scale.full_scale_v(k) for b, where in boards for k in where.inputs),
            output_full_scale_v=self._output_full_scale_v(),
            clock=self.layout.clock,
            max_samples=MAX_SAMPLES - self._delay - GRANULE,
            step_samples=self.layout.step_samples,
            line_delay_s=self.layout.line_delay_s(),
            output_step_v=AMPLITUDE_STEP_V / min(self._output_scales()),
            frequency_step_hz=FREQUENCY_STEP_HZ,
            holds_levels=True,
            unproved_lines=self.layout.unproved_lines() if self._table.prove_wiring else (),
            input_ends_v=tuple(b.scale.ends_v(k) for b, where in boards for k in where.inputs),
        )

    def state(self) -> CardState:
        """See IoCard."""
        return self._state

    def sample(self) -> int | None:
        """See IoCard.  The server answers between chunks; the pointer goes in steps of 32 samples."""
        if self._state is not CardState.RUNNING:
            return None
        return int(self.boards[0].ask("RP:ADC:WP?")[0])

    def timeline(self) -> Timeline | None:
        """The timeline that runs, None if none does."""
        return self._timeline if self._state is CardState.RUNNING else None

    def use_pin(self, board: int, pin: str, *, output: bool) -> None:
        """Another device hangs on this DIO pin; an output is low and kept low by every `stop`.

        Raises ConfigError if the pin is taken.
        """
        self.boards[board].use_pin(pin, output=output)

    def pin(self, board: int, pin: str) -> bool:
        """Level of a DIO pin, read at the pad."""
        return self.boards[board].ask(f"{pin_header(pin)}?")[0] == "ON"

    def set_pin(self, board: int, pin: str, high: bool) -> None:
        """Set a DIO pin.  Raises DeviceError if it does not read back so."""
        found, _ = set_pin(self.boards[board].ask, pin, high=high)
        if found != level(high):
            raise DeviceError(f"{pin} reads back {found}", where=self.boards[board].where, remedy="check its wiring")

    def program(self, timeline: Timeline) -> None:
        """See IoCard."""
        with self._commanding():
            require(self._state, CardState.IDLE, CardState.PROGRAMMED, where=WHERE)
            self._state, asked = CardState.IDLE, (timeline, self._output_full_scale_v())
            same = asked == self._asked
            programs = self._programs if same else compile_timeline(timeline, self.layout, asked[1])
            for board, program in zip(self.boards, programs, strict=True):
                board.load(program)
            self._timeline, self._programs, self._asked = timeline, programs, asked
            self._state = CardState.PROGRAMMED

    def arm(self) -> None:
        """See IoCard."""
        with self._commanding():
            require(self._state, CardState.PROGRAMMED, where=WHERE)
            self._state = CardState.ARMED  # from here on only a run or a new connection ends it
            arm_all(self.boards, self._programs)

    def trigger(self) -> None:
        """See IoCard."""
        with self._commanding():
            require(self._state, CardState.ARMED, where=WHERE)
            assert self._timeline is not None
            self._state = CardState.RUNNING
            total = self._timeline.total_samples
            self._pins = PinLines.of(self.boards, self.layout, self._timeline)
            chunk = min(self._table.chunk_samples, PIN_CHUNK if self._pins.edges else self._table.chunk_samples)
            self._reader = Reader(self.boards, self._programs, self._delay, total, chunk, self._start_samples)
            self._pins.check_pace(chunk)
            self._pins.before_trigger()
            trigger.start(self.boards)
            over_s = time.monotonic() + (self._delay + total) / self.layout.clock.rate_hz
            for board, lock in zip(self.boards, self._locks, strict=True):
                note_recording(lock, over_s)
                board.start_stream(self._delay, total, chunk)

    def read(self, max_samples: int) -> Chunk:
        """See IoCard.  Waits until min(max_samples, samples left) have come."""
        if max_samples < 1:
            raise InputError(f"cannot read {max_samples} samples", where=WHERE, remedy="ask for one or more")
        with self._stoppable():
            require(self._state, CardState.RUNNING, where=WHERE)
            reader = self._reader
            chunk = reader.read(max_samples, self._pins.at)
            with self._guard:
                require(self._state, CardState.RUNNING, where=WHERE)
                if reader.left == 0:
                    self._finish()
            return chunk

    def stop(self) -> None:
        """See IoCard.  An unfinished shot, and one that is being prepared, costs a new connection."""
        with self._stopping:
            if self._state is CardState.CLOSED:
                return
            unfinished = self._state in (CardState.ARMED, CardState.RUNNING)
            failed: list[str] = []
            if unfinished or not self._guard.acquire(timeout=PATIENCE_S):
                unfinished = True
                self._stops += 1
                failed = failures_of(
                    self.boards, Board.replace
                )  # whoever waits for the card wakes up and lets go of it
                self._guard.acquire()
            try:
                self._state, self._timeline = CardState.IDLE, None
                self._all_off(failed, unfinished=unfinished)
            finally:
                self._guard.release()

    def _all_off(self, failed: list[str], *, unfinished: bool) -> None:
        """Read back that outputs are off, over new connections if need be.  Raises DeviceError if they may be on."""
        if not unfinished:
            if not failures_of(self.boards, Board.quiet):
                return
            failed = failures_of(self.boards, Board.replace)
        for board in self.boards:
            failed += [] if failed else failures_of([board], Board.settle)
        failed += [] if failed else failures_of(self.boards, trigger.gone)
        if failed:
            raise DeviceError(
                "outputs could not be confirmed off",
                where=WHERE,
                why="; ".join(failed),
                remedy="switch the amplifier's mains off by hand, then repair the connection",
            )

    def close(self) -> None:
        """See IoCard."""
        if self._state is CardState.CLOSED:
            return
        try:
            self.stop()
        finally:
            self._state = CardState.CLOSED
            self._let_go()

    def _output_full_scale_v(self) -> float:
        """What every output can give: the server refuses more than full scale after its calibration."""
        limits_v = [scale.output_limit_v[k] for scale, k in self._used_outputs()]
        return min(OUTPUT_FULL_SCALE_V, OUTPUT_FULL_SCALE_V / max(self._output_scales()), *limits_v)

    def _output_scales(self) -> list[float]:
        return [scale.output[k] for scale, k in self._used_outputs()] or [1.0]

    def _used_outputs(self) -> list[tuple[Scale, int]]:
        return [(b.scale, k) for b, where in zip(self.boards, self.layout.boards, strict=True) for k in where.outputs]

    def _finish(self) -> None:
        """The last sample is here: let the sequences end, then make the boards ready for the next shot."""
        play_s = self._table.reply_timeout_s + max(p.samples for p in self._programs) / self.layout.clock.rate_hz
        self._pins.low()
        stopped = trigger.wait_for_sequences(self.boards, play_s)
        trigger.end(self.boards)
        self._state = CardState.IDLE
        if stopped:
            raise emergency_stop(", ".join(stopped), "the emergency input switched the outputs off during the shot")

    def _let_go(self) -> None:
        for board in self.boards:
            with contextlib.suppress(DeviceError):
                board.close()
        for lock in self._locks:
            lock.close()
        self._locks = []

    @contextlib.contextmanager
    def _commanding(self) -> Iterator[None]:
        """Nobody else commands the boards meanwhile; errors as in `_stoppable`."""
        with self._guard, self._stoppable():
            yield

    @contextlib.contextmanager
    def _stoppable(self) -> Iterator[None]:
        """A stop takes the connection away: what fails then, fails because of the stop.

        Also a shot refused: the last status record before the eviction tells of a trigger that fell.
        """
        before = self._stops
        try:
            yield
        except (PlatformError, OSError):
            if self._stops != before or self._stopping.locked():
                raise was_stopped(WHERE) from None
            raise
