"""One or several boards as one I/O card.

A shot: `program` uploads the sequences (once per timeline), `arm` sets them and the amplitudes, `trigger` starts the
master and asks every board for the whole recording, `read` takes chunk after chunk from all of them.  After a shot that
runs to its end the servers empty their memories by themselves, and `program` of the next shot waits for that.  An
unfinished shot is ended by a new connection, which zeroes all outputs at once and is the only safe end of a running
sequence.
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Iterator

from drivers.errors import DeviceError, DeviceStateError, InputError, PlatformError
from drivers.identity import Identity
from drivers.io_card import CardCapabilities, CardState, Chunk, require, was_stopped
from drivers.red_pitaya import trigger
from drivers.red_pitaya.board import Board
from drivers.red_pitaya.boards import arm_all, connect_all, failures_of, limit_reply_times, make_boards, prove_boards
from drivers.red_pitaya.capabilities import card_capabilities, output_full_scale_v
from drivers.red_pitaya.emergency import emergency_stop
from drivers.red_pitaya.layout import pin_header
from drivers.red_pitaya.lines import PinLines
from drivers.red_pitaya.lock import CardLock, lock_card
from drivers.red_pitaya.options import CardTable
from drivers.red_pitaya.pins import level, set_pin
from drivers.red_pitaya.reader import Reader
from drivers.red_pitaya.sequence import BoardProgram, compile_timeline
from drivers.red_pitaya.stream import filter_delay_samples
from drivers.timeline import Timeline

WHERE = "I/O card"
PIN_CHUNK = 320  # samples per chunk where lines are set by command, which waits for the end of a chunk
PATIENCE_S = 0.2  # how long a stop waits for commands that are on their way
START_S = 0.1  # how long the server may take to see that a sequence plays


class RedPitayaCard:
    """See drivers.io_card.IoCard."""

    def __init__(self, table: CardTable) -> None:
        """Open all boards; outputs are off when it returns.

        Raises ConfigError, DeviceNotFound, DeviceTimeout, DeviceProtocolError, DeviceDenied if another daemon holds
        a board.
        """
        self._table = table
        self.layout = table.layout()
        self._delay = round(filter_delay_samples(table.decimation))
        self._start_samples = round(START_S * self.layout.clock.rate_hz)
        self.boards = make_boards(table, self.layout)
        self._locks: list[CardLock] = []
        self._guard = threading.RLock()  # held while giving commands; never while waiting for samples
        self._stopping = threading.Lock()
        self._stops = 0
        self._state = CardState.IDLE
        self._uncertain = False  # a board refused a command or did not answer while it was programmed
        self._timeline: Timeline | None = None
        self._programs: tuple[BoardProgram, ...] = ()
        self._compiled_for: tuple[Timeline, float] | None = None  # timeline and full scale, V, of `_programs`
        self._reader = Reader(self.boards, (), start=0, total=0, chunk=1)
        self._pins = PinLines(where=self.boards[0].where, boards={}, edges=())
        try:
            for board in self.boards:
                self._locks.append(lock_card(board.address.host, board.address.command_port))
            connect_all(self.boards, self._locks)
            prove_boards(self.boards, table)
        except Exception:
            self._let_go()
            raise

    def identity(self) -> Identity:
        """See IoCard.  The serial number is the address, because the server reports none."""
        for board in self.boards:
            board.ask("RP:MODE?")
        where = ", ".join(board.address.host for board in self.boards)
        versions = "; ".join(dict.fromkeys(board.version for board in self.boards))
        return Identity("Red Pitaya", f"{len(self.boards)} x STEMlab 125-14, RedPitayaDAQServer", where, versions)

    def capabilities(self) -> CardCapabilities:
        """See IoCard."""
        return card_capabilities(self.boards, self._table, self.layout, self._delay)

    def state(self) -> CardState:
        """See IoCard."""
        return self._state

    def sample(self) -> int | None:
        """See IoCard.  The server answers between chunks; the pointer goes in steps of 32 samples."""
        if self._state is not CardState.RUNNING:
            return None
        with self._stoppable():
            return int(self.boards[0].ask("RP:ADC:WP?")[0])

    def timeline(self) -> Timeline | None:
        """The timeline that runs, None if none does."""
        return self._timeline if self._state is CardState.RUNNING else None

    def use_pin(self, board: int, pin: str, *, output: bool) -> None:
        """Reserve a DIO pin for another device; an output is set low, now and by every `stop`.

        Raises ConfigError if the pin is taken.
        """
        self.boards[board].use_pin(pin, output=output)

    def pin(self, board: int, pin: str) -> bool:
        """Level of a DIO pin, read at the pad."""
        with self._stoppable():
            return self.boards[board].ask(f"{pin_header(pin)}?")[0] == "ON"

    def set_pin(self, board: int, pin: str, high: bool) -> None:
        """Set a DIO pin.  Raises DeviceError if it does not read back so."""
        with self._stoppable():
            found, _ = set_pin(self.boards[board].ask, pin, high=high)
        if found != level(high):
            raise DeviceError(f"{pin} reads back {found}", where=self.boards[board].where, remedy="check its wiring")

    def program(self, timeline: Timeline) -> None:
        """See IoCard."""
        with self._commanding():
            require(self._state, CardState.IDLE, CardState.PROGRAMMED, where=WHERE)
            self._state = CardState.IDLE
            compiled_for = (timeline, output_full_scale_v(self.boards, self.layout))
            same = compiled_for == self._compiled_for
            programs = self._programs if same else compile_timeline(timeline, self.layout, compiled_for[1])
            if not all(board.whole for board in self.boards):
                self._reconnect()
            self._uncertain = True
            trigger.wait_until_cleared(self.boards, self._table.reply_timeout_s)
            for board, program in zip(self.boards, programs, strict=True):
                board.load(program)
            self._uncertain = False
            self._timeline = timeline
            self._programs = programs
            self._compiled_for = compiled_for
            self._state = CardState.PROGRAMMED

    def arm(self) -> None:
        """See IoCard."""
        with self._commanding():
            require(self._state, CardState.PROGRAMMED, where=WHERE)
            self._state = CardState.ARMED  # from here on only a shot or a new connection ends it
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
            self._reader = Reader(
                self.boards,
                self._programs,
                start=self._delay,
                total=total,
                chunk=chunk,
                start_samples=self._start_samples,
            )
            self._pins.check_pace(chunk)
            self._pins.before_trigger()
            if not self._pins.edges:  # otherwise they limit the wait while the gate is high
                limit_reply_times(self.boards, self._programs, self.layout.clock.rate_hz)
            trigger.start(self.boards)
            over_s = time.monotonic() + (self._delay + total) / self.layout.clock.rate_hz
            for board, lock in zip(self.boards, self._locks, strict=True):
                lock.note_recording(over_s)
                board.start_stream(self._delay, total, chunk)

    def read(self, max_samples: int) -> Chunk:
        """See IoCard.  Waits until min(max_samples, samples left) have come."""
        if max_samples < 1:
            raise InputError(f"cannot read {max_samples} samples", where=WHERE, remedy="ask for one or more")
        with self._stoppable():
            require(self._state, CardState.RUNNING, where=WHERE)
            reader = self._reader
            if reader.left == 0:
                raise DeviceStateError("the shot has ended in an error", where=WHERE, remedy="stop the card")
            try:
                chunk = reader.read(max_samples, self._pins.at)
            except DeviceError:
                self._pins.check()  # a gate that was lowered by the timer is the cause
                raise
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
            failed: list[str] = []
            commands = not self._unfinished() and self._guard.acquire(timeout=PATIENCE_S)
            unfinished = not commands or self._unfinished()  # a command that was at work meanwhile may have armed it
            if unfinished:
                self._stops += 1
                # A thread that waits for the card wakes up with DeviceLost and releases the card.
                failed = failures_of(self.boards, Board.replace)
            if not commands:
                self._guard.acquire()
            try:
                self._state = CardState.IDLE
                self._timeline = None
                self._uncertain = False
                self._all_off(failed, unfinished=unfinished)
            finally:
                self._guard.release()

    def _unfinished(self) -> bool:
        """Whether only new connections can end the present state."""
        return self._state in (CardState.ARMED, CardState.RUNNING) or self._uncertain

    def _reconnect(self) -> None:
        """Open new connections as a stop does.  Raises DeviceError; DeviceStateError if a stop came first."""
        if not self._stopping.acquire(blocking=False):
            raise was_stopped(WHERE)
        try:
            self._all_off(failures_of(self.boards, Board.replace), unfinished=True)
        finally:
            self._stopping.release()

    def _all_off(self, failed: list[str], *, unfinished: bool) -> None:
        """Read back that outputs are off, over new connections if need be.  Raises DeviceError if they may be on."""
        if not unfinished:
            if not failures_of(self.boards, Board.quiet):
                return
            failed = failures_of(self.boards, Board.replace)
        for board in self.boards:
            failed += [] if failed else failures_of([board], Board.settle)
        failed += [] if failed else failures_of(self.boards, trigger.wait_until_off)
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

    def _finish(self) -> None:
        """After the last sample: wait for the end of the sequences, then switch the trigger off."""
        play_s = self._table.reply_timeout_s + max(p.samples for p in self._programs) / self.layout.clock.rate_hz
        self._pins.low()
        stopped = trigger.wait_for_sequences(self.boards, play_s)
        if stopped:  # their sequences are not over: only a stop ends them, by new connections
            raise emergency_stop(", ".join(stopped), "the emergency input switched the outputs off during the shot")
        trigger.check_in_step(self.boards, trigger.end(self.boards))
        for board in self.boards:
            board.reply_deadline = None
        self._state = CardState.IDLE

    def _let_go(self) -> None:
        for board in self.boards:
            with contextlib.suppress(DeviceError):
                board.close()
        for lock in self._locks:
            lock.close()
        self._locks = []

    @contextlib.contextmanager
    def _commanding(self) -> Iterator[None]:
        """Exclude other threads from the boards; errors as in `_stoppable`, also if a stop came first."""
        with self._guard, self._stoppable():
            if self._stopping.locked():
                raise was_stopped(WHERE)
            yield

    @contextlib.contextmanager
    def _stoppable(self) -> Iterator[None]:
        """Report a failure that a stop has caused by closing the connection as `was_stopped`.

        That includes ShotRefused: the last status record before the eviction shows that the trigger fell.
        """
        before = self._stops
        try:
            yield
        except (PlatformError, OSError):
            if self._stops != before or self._stopping.locked():
                raise was_stopped(WHERE) from None
            raise
