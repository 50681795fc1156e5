"""One board: its identity, its registers, its sequence, its stream."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from drivers.errors import ConfigError, DeviceError, DeviceProtocolError, DeviceTimeout
from drivers.io_card import ChunkFlags
from drivers.red_pitaya.commands import ENDED, RUNNING, SENDING, TO_CONFIGURE, register_commands
from drivers.red_pitaya.connection import Connection
from drivers.red_pitaya.emergency import EMERGENCY, emergency_stop
from drivers.red_pitaya.layout import DIGITAL_PINS, pin_header
from drivers.red_pitaya.options import BoardTable, CardTable
from drivers.red_pitaya.output_readback import OFF_TOLERANCE_V, OUTPUTS_OFF, READ_BACK, all_off
from drivers.red_pitaya.pairing import open_pair, take_over
from drivers.red_pitaya.pins import low_levels
from drivers.red_pitaya.reply_deadline import ReplyDeadline
from drivers.red_pitaya.scale import Scale, read_scale
from drivers.red_pitaya.sequence import BoardProgram
from drivers.red_pitaya.sines import arming, check_amplitudes
from drivers.red_pitaya.stream import PAIR_BYTES, RECORD, Continuity, Record

OFF_S = 1.0  # a card that has not confirmed by then gets a new connection


@dataclass
class Board:
    """One board and its connection; is_last: it passes the trigger on to no other board.

    reply_deadline: how long answers may take, None: as the table says; written:
    its write pointer at the last `play`, samples; clearing: the server may still be emptying its memory since then.
    """

    address: BoardTable
    table: CardTable
    output_pins: list[str]
    is_last: bool
    input_pins: list[str] = field(init=False, default_factory=list)
    scale: Scale = field(init=False)
    version: str = field(init=False, default="")
    reply_deadline: ReplyDeadline | None = field(init=False, default=None)
    written: int = field(init=False, default=0)
    clearing: bool = field(init=False, default=False)
    _loaded: BoardProgram | None = field(init=False, default=None)
    _sounding: list[str] = field(init=False, default_factory=list)
    _connection: Connection = field(init=False)
    _next: Connection | None = field(init=False, default=None)
    _buffer: bytearray = field(init=False, default_factory=bytearray)

    def open(self) -> None:
        """Connect; all pins go low.  Raises DeviceNotFound, DeviceTimeout, DeviceProtocolError if it is another."""
        low = [f"{pin_header(pin)} OFF" for pin in DIGITAL_PINS]  # all of them, because their use is not known yet
        self._connection = open_pair(*self._address, self.table.reply_timeout_s, [*OUTPUTS_OFF, *low])

    def replace(self) -> None:
        """Open a new connection in place of the old one: the card zeroes its outputs and ends whatever runs, at once.

        A thread that uses the old one gets DeviceLost; the new one is used after `settle`.  Errors as in `open`.
        """
        self._adopt()  # otherwise the last new one would be closed before this one is connected
        self.low(self.output_pins)()  # a new connection ends sines and sequence at once, but no DIO line
        self._next = take_over(self._connection, *self._address, self.table.reply_timeout_s, self._off())

    def settle(self) -> None:
        """After a new connection: check the identity, switch outputs off and read them back, and set all registers.

        The master first: a slave cannot leave its mode while the master's trigger is on.
        """
        self._adopt()
        self._loaded = self.reply_deadline = None
        self._sounding = []
        self.clearing = False
        self._identify()
        self.switch_off()
        self._configure()

    def _adopt(self) -> None:
        """Use the newest connection; the one before it is closed already."""
        if self._next is not None:
            self._connection = self._next
            self._next = None

    @property
    def _address(self) -> tuple[str, tuple[int, int]]:
        return self.address.host, (self.address.command_port, self.address.data_port)

    def close(self) -> None:
        """Close all connections.  Idempotent."""
        for each in (getattr(self, "_connection", None), self._next):
            if each is not None:
                each.close()

    def ask(self, *commands: str) -> list[str | int | float]:
        """See Connection.ask_all."""
        return self._connection.ask_all(commands, self.reply_deadline.remaining_s() if self.reply_deadline else None)

    @property
    def whole(self) -> bool:
        """See Connection.whole."""
        return self._connection.whole

    @property
    def where(self) -> str:
        """The board's address."""
        return f"{self.address.host}:{self.address.command_port}"

    def use_pin(self, pin: str, *, output: bool) -> None:
        """Give a DIO pin its direction; an output goes low.  Raises ConfigError if it has another use already."""
        if pin in (*self.output_pins, *self.input_pins):
            raise ConfigError(f"the pin {pin} is used twice", where=self.where, remedy="give each device its own")
        header = pin_header(pin)
        if output:
            self.output_pins.append(pin)
            self.ask(f"{header} OFF", f"{header}:HBRIDGE OFF", f"{header}:DIR OUT")
        else:
            self.input_pins.append(pin)
            self.ask(f"{header}:DIR IN")

    # --- outputs

    def load(self, program: BoardProgram) -> None:
        """Upload a sequence, in mode CONFIGURATION; nothing is sent if it has been uploaded already.

        All tables are uploaded, because only SEQ:SET removes those that a former client has uploaded and not set: they
        would be played together with these, possibly gate and receiver at once.
        """
        if program.silent or self._is_loaded(program):
            return
        self._loaded = None
        steps, channels = program.levels_v.shape
        self.ask(f"RP:DAC:SEQ:SAMPLESPERSTEP {program.step_samples}", f"RP:DAC:SEQ:CHAN {channels}")
        self._connection.upload(f"RP:DAC:SEQ:LUT {steps},1", program.levels_v.astype("<f4").tobytes())
        self._connection.upload("RP:DAC:SEQ:LUT:ENABLE", program.enable.tobytes())
        self._connection.upload("RP:DAC:SEQ:LUT:RESYNC", bytes(steps * min(channels, 2)))
        self.ask("RP:DAC:SEQ:LUT:UP 0,0", "RP:DAC:SEQ:LUT:DOWN 0,0")
        self._loaded = program

    def arm(self, program: BoardProgram) -> None:
        """Sequence and sines into the registers, once per shot; then mode ACQUISITION.  Silence needs no sequence.

        While the trigger is off the card holds everything at zero.  Raises DeviceProtocolError if an amplitude reads
        back wrong, DeviceFault if the emergency input is high.
        """
        scales = [self.scale.output[s.output] for s in program.sines]
        waves, amplitudes, checks = arming(program.sines, scales)
        self._sounding = checks
        sequence = [] if program.silent else ["RP:DAC:SEQ:SET"]
        commands = [*waves, *sequence, *amplitudes, *checks, "RP:MODE ACQUISITION"]
        emergency, *answers = self.ask("RP:INSTANTRESET:STATUS?", *commands)
        if emergency and self.table.instant_reset:
            raise emergency_stop(self.where, "the emergency input keeps the outputs off")
        found = [float(v) for v in answers[len(answers) - 1 - len(checks) : -1]]
        check_amplitudes(program.sines, scales, found, self.where)
        self._sounding = [question for question, volts in zip(checks, found, strict=True) if volts]

    def quiet(self) -> None:
        """DIO lines low, sines and offsets read back off, and switched off if they are not; errors as in `switch_off`.

        Most shots end with their sequence, which has zeroed them.  DIO lines are always set low, because the read-back
        shows the pad, which may be low although the line is not.
        """
        lows = self._lows()
        if not all_off(self._connection.ask_all([*lows, *self._levels()], OFF_S)[len(lows) :], 0.0):
            self.switch_off()

    def switch_off(self) -> None:
        """Sines, offsets and DIO lines off, and read back.  Raises DeviceError if they are not."""
        off = self._off()
        found = self._connection.ask_all([*off, *self._levels()], OFF_S)[len(off) :]
        if any(each != "OFF" for each in found[len(READ_BACK) :]):
            found[len(READ_BACK) :] = low_levels(self._connection, self.output_pins, OFF_S)
        if not all_off(found, OFF_TOLERANCE_V):
            raise DeviceError(
                "outputs could not be confirmed off",
                where=self.where,
                why=f"read back: {found[: len(READ_BACK)]} V, lines {found[len(READ_BACK) :]}",
                remedy="switch the amplifier's mains off by hand",
            )

    def _off(self) -> list[str]:
        return [*OUTPUTS_OFF, *self._lows()]

    def _lows(self) -> list[str]:
        return [f"{pin_header(pin)} OFF" for pin in self.output_pins]

    def low(self, pins: Sequence[str]) -> Callable[[], None]:
        """A function that sets these pins low by the last command of this connection, whichever thread waits."""
        return partial(self._connection.send_final, [f"{pin_header(pin)} OFF" for pin in pins])

    def _levels(self) -> list[str]:
        """Questions for what `all_off` takes."""
        return [*READ_BACK, *(f"{pin_header(pin)}?" for pin in self.output_pins)]

    def play(self) -> tuple[bool, bool]:
        """Whether the shot continues, and whether the emergency input has switched the outputs off since the trigger.

        That input holds the step counter, too: a sequence that it has stopped seems to run for ever.  A busy server may
        not have noticed the trigger yet, but then it has not zeroed the amplitudes either; a sequence that is set again
        in that state would open all gates.  A server that has zeroed them empties its memory for 50 ms (see
        `is_cleared`).  While it sends samples, it refuses the commands that end a shot.
        """
        status, emergency, written, mode, *volts = self.ask(*ENDED, *self._sounding)
        self.written = int(written)
        plays = any(map(float, volts)) if volts else bool(int(status) & RUNNING)
        self.clearing = bool(volts) and not plays  # the status is that of a moment before
        return plays or mode == SENDING, bool(emergency) and self.table.instant_reset

    def is_cleared(self) -> bool:
        """Whether the server has cleared its memory of the last sequence; only then does it accept another."""
        self.clearing = bool(int(self.ask("RP:STATUS?")[0]) & RUNNING)
        return not self.clearing

    def watch(self) -> None:
        """Ask for the emergency input without waiting, and look at the answer to the question before.

        Raises DeviceFault if the input has switched the outputs off since the trigger.
        """
        if not self.table.instant_reset:
            return
        answers = self._connection.posted()
        if answers is not None and any(answers):
            raise emergency_stop(self.where)
        if answers != []:  # the question before has its answer, or there was none
            self._connection.post(EMERGENCY)

    # --- samples

    def account(self, program: BoardProgram, start_samples: int) -> Continuity:
        """The check of a shot's recording; start_samples: how late the server may report that it plays."""
        return Continuity(self.where, program.samples, start_samples)

    def start_stream(self, start: int, count: int, chunk: int) -> None:
        """Ask for `count` samples from `start` on, in chunks."""
        self._buffer = bytearray(chunk * PAIR_BYTES + RECORD.size)
        self.ask(f"RP:ADC:DATA:PIPELINED? {start},{count},{chunk}")

    def next_chunk(self, first: int, count: int, account: Continuity) -> tuple[NDArray[np.float32], ChunkFlags]:
        """The next chunk, whose first sample has the raw index `first`: (used inputs, count) float32 V.

        Raises DeviceTimeout if it does not come, ShotRefused from `account`.
        """
        raw = memoryview(self._buffer)[: count * PAIR_BYTES + RECORD.size]
        timeout_s = self.reply_deadline.remaining_s() if self.reply_deadline else self.table.sample_timeout_s
        self._connection.receive_into(raw, timeout_s)
        record = Record.parse(raw[count * PAIR_BYTES :], first)
        account.check(record)
        pairs = np.frombuffer(raw, "<i2", 2 * count).reshape(count, 2)
        used = list(self.address.inputs)
        return pairs.T[used] * self.scale.scale_v[used, None] + self.scale.offset_v[used, None], record.flags

    # --- start

    def _is_loaded(self, program: BoardProgram) -> bool:
        return self._loaded is not None and self._loaded.same_steps(program)

    def _identify(self) -> None:
        try:
            image, server = self.ask("RP:VERSION:IMAGE?", "RP:VERSION:SERVER?")
        except DeviceTimeout:
            image = "unknown"
            server = "unknown"
        wanted = self.table.server_version
        wanted_image = wanted if self.table.image_version is None else self.table.image_version
        if (image, server) != (wanted_image, wanted):
            raise DeviceProtocolError(
                f"the card's image is version {image} and its server version {server}, not {wanted_image} and {wanted}",
                where=self.where,
                why="the protocol differs between versions",
                remedy="update the card's DAQ server, or set io_card.server_version and io_card.image_version if you "
                "know that it behaves alike",
            )
        self.version = f"server {server}"
        self.scale = read_scale(self.ask, self.table, self.where)
        if not self.scale.calibrated:
            self.version += ", inputs not calibrated"

    def _configure(self) -> None:
        self.ask(*TO_CONFIGURE)
        self.ask(*register_commands(self.table, self.output_pins, self.input_pins, is_last=self.is_last))
        found = self.ask("RP:ADC:DECIMATION?")[0]
        if found != self.table.decimation:
            raise DeviceProtocolError(
                f"the decimation reads back as {found}, not {self.table.decimation}",
                where=self.where,
                remedy="make sure that no other client uses the card",
            )
