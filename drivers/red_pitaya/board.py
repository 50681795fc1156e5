"""One board: who it is, its registers, its sequence, its stream."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import structlog
from numpy.typing import NDArray

from drivers.errors import ConfigError, DeviceError, DeviceProtocolError, DeviceTimeout
from drivers.io_card import ChunkFlags
from drivers.red_pitaya.connection import Connection
from drivers.red_pitaya.layout import pin_header
from drivers.red_pitaya.options import BoardTable, CardTable
from drivers.red_pitaya.ports import use_up_strangers
from drivers.red_pitaya.scale import Scale, read_scale
from drivers.red_pitaya.sequence import COMPONENTS, BoardProgram, Sine
from drivers.red_pitaya.stream import PAIR_BYTES, RECORD, Continuity, Record

log = structlog.get_logger()

AMPLITUDE_STEP_V = 1 / 32767  # of the register, which truncates; divided by the output's scale
SINES = [(output, component) for output in (0, 1) for component in range(COMPONENTS)]
OUTPUTS_OFF = [
    *(f"RP:DAC:CHANNEL{o}:COMPONENT{c}:AMPLITUDE 0" for o, c in SINES),
    *(f"RP:DAC:CHANNEL{o}:OFFSET 0" for o in (0, 1)),
]
READ_BACK = [
    *(f"RP:DAC:CHANNEL{o}:COMPONENT{c}:AMPLITUDE?" for o, c in SINES),
    *(f"RP:DAC:CHANNEL{o}:OFFSET?" for o in (0, 1)),
]
OFF_S = 1.0  # a card that has not confirmed by then is connected anew
QUIET_V = 1e-4  # an offset register may read back its calibration's last digit


@dataclass
class Board:
    """One board and its connection; the last one passes the trigger on to nobody."""

    address: BoardTable
    table: CardTable
    output_pins: list[str]
    is_last: bool
    input_pins: list[str] = field(init=False, default_factory=list)
    scale: Scale = field(init=False)
    version: str = field(init=False, default="")
    _loaded: BoardProgram | None = field(init=False, default=None)
    _connection: Connection = field(init=False)
    _buffer: bytearray = field(init=False, default_factory=bytearray)

    def open(self) -> None:
        """Connect.  Raises DeviceNotFound, DeviceTimeout, DeviceProtocolError if something else answers."""
        a = self.address
        self._connection = Connection.open(a.host, a.command_port, a.data_port, self.table.reply_timeout_s)

    def take_over(self) -> None:
        """A new connection in place of the old one: the card zeroes its outputs and ends whatever runs, at once."""
        a, old = self.address, self._connection
        try:
            self._connection = Connection.take_over(a.host, a.command_port, a.data_port, self.table.reply_timeout_s)
        finally:
            old.close()
        if old.starved:
            self._pair_anew()

    def _pair_anew(self) -> None:
        """The data connection may be a stranger's, and so would be the next ones: off first, then get through."""
        a = self.address
        self.switch_off()
        self._connection.close()
        use_up_strangers(a.host, a.command_port)
        self._connection = Connection.open(a.host, a.command_port, a.data_port, self.table.reply_timeout_s)

    def settle(self) -> None:
        """After a new connection: outputs off and read back, who is there, and all registers.

        The master first: a slave cannot leave its mode while the master's trigger is on.
        """
        self._loaded = None
        self.switch_off()
        self._identify()
        self._configure()

    def prove_data_connection(self, silent: BoardProgram) -> None:
        """Load a silent sequence, in mode CONFIGURATION, over the data connection; another one if that is not ours.

        Whoever died between its two connections, a daemon that was killed while it started for one, left its data
        connection behind, and the card takes it for ours.  What it says to an upload then is not documented: silence,
        a refusal, a lost connection all count.  Raises DeviceError if nothing helps.
        """
        try:
            self.load(silent)
        except DeviceError:
            self._connection.starved = True
            self.take_over()
            self.settle()
            self.load(silent)

    def close(self) -> None:
        """Let go.  Idempotent."""
        if hasattr(self, "_connection"):
            self._connection.close()

    def ask(self, *commands: str) -> list[str | int | float]:
        """See Connection.ask_all."""
        return self._connection.ask_all(commands)

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
        """Upload a sequence, in mode CONFIGURATION; nothing is sent if it is there already."""
        if self._is_loaded(program):
            return
        self._loaded = None
        steps, channels = program.levels_v.shape
        self.ask(f"RP:DAC:SEQ:SAMPLESPERSTEP {program.step_samples}", f"RP:DAC:SEQ:CHAN {channels}")
        self._connection.upload(f"RP:DAC:SEQ:LUT {steps},1", program.levels_v.astype("<f4").tobytes())
        self._connection.upload("RP:DAC:SEQ:LUT:ENABLE", program.enable.tobytes())
        self._loaded = program

    def arm(self, program: BoardProgram) -> None:
        """Sequence and sines into the registers, once per shot; then mode ACQUISITION.

        While the trigger is off the card holds everything at zero.  Raises DeviceProtocolError if an amplitude reads
        back wrong.
        """
        sines = [command for sine in program.sines for command in _sine(sine)]
        scales = [self.scale.output[s.output] for s in program.sines]
        wanted = [_truncated(s.amplitude_v, scale) for s, scale in zip(program.sines, scales, strict=True)]
        amplitudes = [f"{_component(s)}:AMPLITUDE {v:.15g}" for s, v in zip(program.sines, wanted, strict=True)]
        checks = [f"{_component(s)}:AMPLITUDE?" for s in program.sines]
        answers = self.ask(*sines, "RP:DAC:SEQ:SET", *amplitudes, *checks, "RP:MODE ACQUISITION")
        found = answers[len(answers) - 1 - len(checks) : -1]
        for sine, scale, value in zip(program.sines, scales, found, strict=True):
            # What is read back is the register, which holds the voltage times the output's scale.
            if not abs(float(value) - sine.amplitude_v * scale) <= 1.5 * AMPLITUDE_STEP_V:
                raise DeviceProtocolError(
                    f"an amplitude of {sine.amplitude_v} V reads back as {value} V, at an output scale of {scale:g}",
                    where=self.where,
                    remedy="check the output calibration in the card's memory",
                )

    def quiet(self) -> None:
        """DIO lines low, sines and offsets read back off, and switched off if they are not; errors as in `switch_off`.

        A sequence that has ended has zeroed them, and that is how most shots end.  A line reads back its pad, which
        may be low though the line is not: it is always told.
        """
        lows = self._lows()
        if not _all_off(self._connection.ask_all([*lows, *self._levels()], OFF_S)[len(lows) :], 0.0):
            self.switch_off()

    def switch_off(self) -> None:
        """Sines, offsets and DIO lines off, and read back.  Raises DeviceError if they are not."""
        off = [*OUTPUTS_OFF, *self._lows()]
        found = self._connection.ask_all([*off, *self._levels()], OFF_S)[len(off) :]
        if not _all_off(found, QUIET_V):
            raise DeviceError(
                "outputs could not be confirmed off",
                where=self.where,
                why=f"read back: {found[: len(READ_BACK)]} V, lines {found[len(READ_BACK) :]}",
                remedy="switch the amplifier's mains off by hand",
            )

    def _lows(self) -> list[str]:
        return [f"{pin_header(pin)} OFF" for pin in self.output_pins]

    def _levels(self) -> list[str]:
        """Questions for what `_all_off` takes."""
        return [*READ_BACK, *(f"{pin_header(pin)}?" for pin in self.output_pins)]

    def play(self) -> tuple[bool, bool]:
        """Whether the sequence runs, and whether the emergency input has switched the outputs off since the trigger."""
        asked = ["RP:STATUS?", "RP:INSTANTRESET:TRIGGERED?"] if self.table.instant_reset else ["RP:STATUS?"]
        status, *emergency = self.ask(*asked)
        return bool(int(status) & 16), any(emergency)

    # --- samples

    def start_stream(self, start: int, count: int, chunk: int) -> None:
        """Ask for `count` samples from `start` on, in chunks."""
        self._buffer = bytearray(chunk * PAIR_BYTES + RECORD.size)
        self.ask(f"RP:ADC:DATA:PIPELINED? {start},{count},{chunk}")

    def next_chunk(self, first: int, count: int, account: Continuity) -> tuple[NDArray[np.float32], ChunkFlags]:
        """The next chunk, whose first sample has the raw index `first`: (used inputs, count) float32 V."""
        raw = memoryview(self._buffer)[: count * PAIR_BYTES + RECORD.size]
        self._connection.receive_into(raw, self.table.sample_timeout_s)
        record = Record.parse(raw[count * PAIR_BYTES :], first)
        account.check(record)
        pairs = np.frombuffer(raw, "<i2", 2 * count).reshape(count, 2)
        used = list(self.address.inputs)
        volts = pairs.T[used] * self.scale.scale_v[used, None] + self.scale.offset_v[used, None]
        return volts, record.flags

    # --- start

    def _is_loaded(self, program: BoardProgram) -> bool:
        old = self._loaded
        if old is None or old is program:
            return old is program
        same_steps = old.step_samples == program.step_samples and np.array_equal(old.levels_v, program.levels_v)
        return same_steps and np.array_equal(old.enable, program.enable)

    def _identify(self) -> None:
        try:
            image, server = self.ask("RP:VERSION:IMAGE?", "RP:VERSION:SERVER?")
        except DeviceTimeout:
            image, server = "unknown", "unknown"
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
        """Every register that survives a reconnect, whoever set it; the trigger must be off to leave ACQUISITION."""
        self.ask("RP:MODE ACQUISITION", "RP:TRIGGER OFF", "RP:TRIGGER:ALIVE OFF", "RP:MODE CONFIGURATION")
        self.ask(
            "RP:ADC:FIRENABLED ON",
            f"RP:ADC:DECIMATION {self.table.decimation}",
            f"RP:TRIGGER:MODE {self.table.trigger.upper()}",
            f"RP:TRIGGER:PROP {'OFF' if self.is_last else 'ON'}",
            "RP:COUNTERTRIGGER:ENABLE OFF",
            "RP:COUNTER:SAMPLESPERSTEP 0",
            f"RP:INSTANTRESET:MODE {'ON' if self.table.instant_reset else 'OFF'}",
            *(f"RP:DAC:CHANNEL{o}:RAMPING:ENABLE OFF" for o in (0, 1)),
            *(f"RP:DAC:CHANNEL{o}:COMPONENT{c}:SIGNALTYPE SINE" for o, c in SINES),
            *(f"{pin_header(pin)}:HBRIDGE OFF" for pin in self.output_pins),  # or it carries pulses, not a level
            *(f"{pin_header(pin)}:DIR OUT" for pin in self.output_pins),
            *(f"{pin_header(pin)}:DIR IN" for pin in self.input_pins),
        )
        found = self.ask("RP:ADC:DECIMATION?")[0]
        if found != self.table.decimation:
            raise DeviceProtocolError(
                f"the decimation reads back as {found}, not {self.table.decimation}",
                where=self.where,
                remedy="make sure that nobody else uses the card",
            )


def _all_off(found: Sequence[str | int | float], at_most_v: float) -> bool:
    """Answers to READ_BACK, then levels of lines: voltages no larger than this, lines low."""
    volts, levels = found[: len(READ_BACK)], found[len(READ_BACK) :]
    return all(abs(float(v)) <= at_most_v for v in volts) and all(level == "OFF" for level in levels)


def _component(sine: Sine) -> str:
    return f"RP:DAC:CHANNEL{sine.output}:COMPONENT{sine.component}"


def _sine(sine: Sine) -> list[str]:
    head = _component(sine)
    return [f"{head}:FREQUENCY {sine.frequency_hz:.15g}", f"{head}:PHASE {sine.phase_rad:.15g}"]


def _truncated(volts: float, scale: float) -> float:
    """The voltage to ask for so that the truncating register, `volts * scale` in steps, ends on the nearest step."""
    most = 1.0 if scale == 1.0 else 1.0 - 0.5 * AMPLITUDE_STEP_V  # the product may be rounded up, and 1 is the limit
    return min((math.floor(volts * scale / AMPLITUDE_STEP_V + 0.5) + 0.25) * AMPLITUDE_STEP_V, most) / scale
