"""The command table of the I/O card's server: who answers which header, and with what.

A handler gets the connection, the numbers in the header and the arguments, and returns the reply, None: it says
nothing.  `Code` is a negative reply.  Handlers run with the world's lock held, except those that wait for an upload.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sim_backend.emulators.board import Board, Mode
from sim_backend.emulators.registers import (
    AMPLITUDE_CODES,
    AWG_SAMPLES,
    COMPONENTS,
    FREQUENCY_STEP_HZ,
    OUTPUTS,
    PHASE_STEP_RAD,
    PINS,
    SIGNALS,
)
from sim_backend.emulators.scpi import CommandTable
from sim_backend.emulators.sequence import State
from sim_backend.emulators.tape import RING

RANGE, BAD_CHANNEL, BAD_COMPONENT, BAD_MODE, MISSING, NOT_CONFIGURABLE = -2, -3, -4, -5, -6, -7
UNSPECIFIED = -1
STEP_CLOCKS = 2**31


class Code(Exception):
    """A refusal: the reply is its number."""

    def __init__(self, number: int) -> None:
        self.number = number


class Silence(Exception):
    """The parser gives up: no reply."""


class Connection(Protocol):
    """What a handler needs of the server."""

    board: Board

    def upload(self, count: int) -> bytes:
        """So many bytes from the data socket; shorter if the client is gone."""

    def start_sending(self, start: int, count: int, chunk: int | None) -> None:
        """Send samples; chunk None: at once and without records."""

    def stop_sending(self) -> bool:
        """End a pipelined read; True if there was one."""

    def send_log(self) -> None:
        """The log file on the data socket."""

    def next_error(self) -> str:
        """The oldest entry of the error queue."""


Handler = Callable[[Connection, tuple[int, ...], list[str]], str | None]


# --- arguments


def number(arguments: list[str], place: int = 0) -> float:
    """A number.  Raises Code if it is missing or is none, Silence if a blank stands where a comma should."""
    if place >= len(arguments) or not arguments[place]:
        raise Code(MISSING)
    if " " in arguments[place]:
        raise Silence
    try:
        value = float(arguments[place])
    except ValueError:
        raise Code(MISSING) from None
    if not np.isfinite(value):
        raise Code(RANGE)
    return value


def whole(arguments: list[str], place: int = 0) -> int:
    """A whole number."""
    return int(number(arguments, place))


def word(arguments: list[str], *words: str) -> str:
    """One of some words, in any case."""
    if not arguments or arguments[0].upper() not in words:
        raise Code(MISSING)
    return arguments[0].upper()


def quoted(text: str) -> str:
    """As the server writes words."""
    return f'"{text}"'


def exact(value: float) -> str:
    """As the server writes doubles."""
    return f"{value:.15g}"


def short(value: float) -> str:
    """As the server writes floats."""
    return f"{value:.6g}"


def need(board: Board, *modes: Mode, code: int = BAD_MODE) -> None:
    """Raises Code in any other mode."""
    if board.mode not in modes:
        raise Code(code)


def configurable(board: Board) -> None:
    """Raises Code if the sequence cannot be changed now."""
    if board.mode is not Mode.CONFIGURATION or board.sequence.state is State.RUNNING:
        raise Code(NOT_CONFIGURABLE)


def channel_of(numbers: tuple[int, ...]) -> int:
    """A DAC or ADC channel."""
    if numbers[0] >= OUTPUTS:
        raise Code(BAD_CHANNEL)
    return numbers[0]


def component_of(numbers: tuple[int, ...], most: int = COMPONENTS) -> tuple[int, int]:
    """Channel and component, 0..most."""
    if numbers[1] > most:
        raise Code(BAD_COMPONENT)
    return channel_of(numbers), numbers[1]


# --- server


def set_mode(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """`RP:MODe`."""
    asked = word(a, "CONFIGURATION", "ACQUISITION", "TRANSMISSION")
    need(c.board, Mode.CONFIGURATION, Mode.ACQUISITION)
    if asked == "TRANSMISSION":
        raise Code(UNSPECIFIED)
    c.board.mode = Mode(asked)
    return "1"


# --- waveforms


def set_amplitude(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
    """V, 0 ... 1/scale; that of the fourth component has no effect."""
    channel, component = component_of(n)
    volts = number(a)
    if not 0 <= volts <= 1 / c.board.scales["DAC", 0 if component == COMPONENTS else channel]:
        raise Code(RANGE)
    level = int(volts * AMPLITUDE_CODES) / AMPLITUDE_CODES
    return _component(c.board, channel, component, amplitude_v=level)


def set_frequency(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
    """Hz, 0.03 ... 125 MHz."""
    channel, component = component_of(n)
    hz = number(a)
    if not 0.03 <= hz < 125e6:
        raise Code(RANGE)
    return _component(c.board, channel, component, frequency_hz=round(hz / FREQUENCY_STEP_HZ) * FREQUENCY_STEP_HZ)


def set_phase(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
    """rad."""
    channel, component = component_of(n)
    return _component(c.board, channel, component, phase_rad=round(number(a) / PHASE_STEP_RAD) * PHASE_STEP_RAD)


def set_signal(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
    """Waveform of components 0..2."""
    channel, component = component_of(n, COMPONENTS - 1)
    return _component(c.board, channel, component, signal=word(a, *SIGNALS))


def _component(board: Board, channel: int, component: int, **changes: float | str) -> str:
    output = board.registers.outputs[channel].with_component(component, **changes)
    board.write(board.registers.with_output(channel, output))
    return "1"


def _get_component(name: str) -> Handler:
    def get(c: Connection, n: tuple[int, ...], _: list[str]) -> str:
        channel, component = component_of(n)
        value = getattr(c.board.registers.outputs[channel].components[component], name)
        return quoted(value) if name == "signal" else exact(value)

    return get


def set_offset(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
    """V, -1 ... 1."""
    channel, volts = channel_of(n), number(a)
    if abs(volts) > 1:
        raise Code(RANGE)
    level = int(volts * AMPLITUDE_CODES) / AMPLITUDE_CODES
    return _output(c.board, channel, offset_v=level)


def _output(board: Board, channel: int, **changes: object) -> str:
    output = replace(board.registers.outputs[channel], **changes)  # type: ignore[arg-type]
    board.write(board.registers.with_output(channel, output))
    return "1"


def set_table(c: Connection, n: tuple[int, ...], _: list[str]) -> str:
    """16384 float32 on the data socket."""
    channel = channel_of(n)
    table = floats(c, AWG_SAMPLES).astype(np.float64)
    if table.size < AWG_SAMPLES or not np.all(np.abs(table) <= 1):
        return "0"
    with c.board.cards.world.lock:
        return _output(c.board, channel, table=table)


def set_ramp(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
    """Length of the ramp, s."""
    channel, seconds = channel_of(n), number(a)
    if seconds <= 0:
        raise Code(RANGE)
    return _output(c.board, channel, ramp_s=seconds)


def enable_ramp(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
    """ON or OFF."""
    need(c.board, Mode.CONFIGURATION)
    return _output(c.board, channel_of(n), ramp_enabled=word(a, "ON", "OFF") == "ON", ramp_down=False)


def ramp_down(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
    """Begin the way down; cannot be undone."""
    need(c.board, Mode.ACQUISITION, Mode.TRANSMISSION)
    channel, asked = channel_of(n), word(a, "ON", "OFF") == "ON"
    return _output(c.board, channel, ramp_down=asked or c.board.registers.outputs[channel].ramp_down)


def ramp_status(c: Connection, _: tuple[int, ...], __: list[str]) -> str:
    """Bit 0 enabled, bits 1-2: 0 normal, 1 done, 2 up, 3 down; the second output four bits higher."""
    status = 0
    for k, output in enumerate(c.board.registers.outputs):
        rising = c.board.triggered and c.board.elapsed() < output.ramp_s * c.board.rate_hz
        state = 3 if output.ramp_down else 2 if rising else 1 if c.board.triggered else 0
        status |= (1 | state << 1) << 4 * k if output.ramp_enabled else 0
    return str(status)


# --- sequence


def floats(c: Connection, count: int) -> NDArray[np.float32]:
    """So many float32 from the data socket."""
    raw = c.upload(4 * count)
    return np.frombuffer(raw[: len(raw) // 4 * 4], "<f4")


def set_step(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """Samples per step; kept in clocks of 125 MHz."""
    configurable(c.board)
    clocks = whole(a) * c.board.decimation
    if not 0 <= clocks < STEP_CLOCKS or clocks % 2:
        raise Code(RANGE)
    c.board.sequence.clocks_per_step = clocks
    return "1"


def set_channels(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """How many channels the tables have."""
    configurable(c.board)
    c.board.sequence.channels = whole(a)
    return "1"


def _shape(c: Connection, a: list[str]) -> tuple[int, int]:
    """Steps and repetitions of an upload."""
    configurable(c.board)
    if c.board.sequence.channels <= 0:
        raise Code(NOT_CONFIGURABLE)
    steps, repetitions = whole(a, 0), whole(a, 1)
    if steps < 1 or repetitions < 1:
        raise Code(RANGE)
    return steps, repetitions


def _table(c: Connection, steps: int) -> NDArray[np.float32]:
    channels = c.board.sequence.channels
    values = floats(c, steps * channels)
    if values.size < steps * channels:
        raise Silence
    return values.reshape(steps, channels)


def upload_main(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """`SEQ:LUT steps,repetitions` and the values."""
    steps, repetitions = _shape(c, a)
    c.board.sequence.upload(_table(c, steps), repetitions)
    return "1"


def _upload_ramp(down: bool) -> Handler:
    def upload(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
        steps, repetitions = _shape(c, a)
        c.board.sequence.upload_ramp(_table(c, steps), repetitions, down=down)
        return "1"

    return upload


def _bits(c: Connection, channels: int) -> NDArray[np.bool_]:
    configurable(c.board)
    steps = c.board.sequence.steps()
    if not steps or channels <= 0:
        raise Code(NOT_CONFIGURABLE)
    raw = c.upload(steps * channels)
    if len(raw) < steps * channels:
        raise Silence
    return np.frombuffer(raw, np.uint8).reshape(steps, channels) != 0


def upload_enable(c: Connection, _: tuple[int, ...], __: list[str]) -> str:
    """`SEQ:LUT:ENaBle` and the bytes."""
    c.board.sequence.upload_enable(_bits(c, c.board.sequence.channels))
    return "1"


def upload_resync(c: Connection, _: tuple[int, ...], __: list[str]) -> str:
    """`SEQ:LUT:ReSYNC` and the bytes: of at most two channels."""
    c.board.sequence.upload_resync(_bits(c, min(c.board.sequence.channels, OUTPUTS)))
    return "1"


def set_sequence(c: Connection, _: tuple[int, ...], __: list[str]) -> str:
    """`SEQ:SET`."""
    configurable(c.board)
    if c.board.sequence.channels <= 0:
        return "0"
    c.board.sequence.set(c.board.sequence.clocks_per_step // c.board.decimation)
    return "1"


def clear_sequence(c: Connection, _: tuple[int, ...], __: list[str]) -> str:
    """`SEQ:CLEAR`."""
    configurable(c.board)
    c.board.sequence.clear()
    return "1"


# --- acquisition


def set_decimation(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """Even, 8 ... 8192."""
    need(c.board, Mode.CONFIGURATION)
    decimation = whole(a)
    if not 8 <= decimation <= 8192 or decimation % 2:
        raise Code(RANGE)
    c.board.decimation = decimation
    return "1"


def set_fir(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """ON or OFF."""
    if not a or a[0].upper() not in ("ON", "OFF"):
        return "0"
    c.board.fir = a[0].upper() == "ON"
    return "1"


def read_simple(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """`ADC:DATa? start,count`."""
    need(c.board, Mode.ACQUISITION)
    c.start_sending(whole(a, 0), whole(a, 1), None)
    return "1"


def read_pipelined(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """`ADC:DATa:PIPElined? start,count,chunk`."""
    need(c.board, Mode.ACQUISITION)
    start, count, chunk = whole(a, 0), whole(a, 1), whole(a, 2)
    if min(start, count) < 0 or chunk < 1:
        raise Code(RANGE)
    c.start_sending(start, count, chunk)
    return "1"


def set_trigger(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """ON or OFF; OFF ends keep-alive as well."""
    need(c.board, Mode.ACQUISITION)
    c.board.trigger_on = word(a, "ON", "OFF") == "ON"
    if not c.board.trigger_on:
        c.board.keep_alive = False
    c.board.cards.update_trigger()
    return "1"


def set_trigger_mode(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """INTERNAL or EXTERNAL."""
    need(c.board, Mode.CONFIGURATION)
    c.board.trigger_mode = word(a, "INTERNAL", "EXTERNAL")
    c.board.cards.update_trigger()
    return "1"


def set_propagation(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """ON or OFF."""
    need(c.board, Mode.CONFIGURATION)
    c.board.propagate = word(a, "ON", "OFF") == "ON"
    c.board.cards.update_trigger()
    return "1"


def set_keep_alive(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """ON or OFF."""
    need(c.board, Mode.ACQUISITION)
    c.board.keep_alive = word(a, "ON", "OFF") == "ON"
    return "1"


# --- pins


def _pin(side: str, n: tuple[int, ...]) -> str:
    name = f"{n[0]}{side}"
    if name not in PINS:
        raise Code(BAD_CHANNEL)
    return name


def _set_direction(side: str) -> Handler:
    def handle(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
        c.board.pin_out[_pin(side, n)] = word(a, "IN", "OUT") == "OUT"
        c.board.set_pins()
        return "1"

    return handle


def _set_level(side: str) -> Handler:
    def handle(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
        c.board.pin_on[_pin(side, n)] = word(a, "ON", "OFF") == "ON"
        c.board.set_pins()
        return "1"

    return handle


def _pin_commands(side: str) -> dict[str, Handler]:
    head = f"RP:DIO:Pin#:Side{side}"
    return {
        f"{head}:DIR": _set_direction(side),
        f"{head}:DIR?": lambda c, n, a: quoted("OUT" if c.board.pin_out.get(_pin(side, n), True) else "IN"),
        f"{head}:HBridge": lambda c, n, a: "1" if _pin(side, n) and word(a, "ON", "OFF") else None,
        f"{head}:HBridge?": lambda c, n, a: quoted("OFF") if _pin(side, n) else None,
        head: _set_level(side),
        f"{head}?": lambda c, n, a: _on_off(_pin(side, n) in c.board.registers.pins),
    }


def _on_off(level: bool) -> str:
    return quoted("ON" if level else "OFF")


# --- words and numbers that only stay where they are


def _set_word(name: str, *words: str) -> Handler:
    def handle(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
        c.board.words[name] = word(a, *words)
        return "1"

    return handle


def _set_number(name: str, *, sequence: bool = False) -> Handler:
    def handle(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
        configurable(c.board) if sequence else need(c.board, Mode.CONFIGURATION)
        c.board.numbers[name] = whole(a)
        return "1"

    return handle


def _set_counter_trigger(name: str) -> Handler:
    def handle(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
        c.board.counter_trigger[name] = word(a, "ON", "OFF") == "ON"
        c.board.cards.update_trigger()
        return "1"

    return handle


def set_source(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """Channel of the counter trigger."""
    need(c.board, Mode.CONFIGURATION)
    if not a:
        raise Code(MISSING)
    c.board.words["source"] = a[0]
    return "1"


# --- calibration


def _get_calibration(kind: str, values: str) -> Handler:
    def get(c: Connection, n: tuple[int, ...], _: list[str]) -> str:
        return short(getattr(c.board, values).get((kind, n[0]), float("nan")))

    return get


def _set_calibration(kind: str, values: str) -> Handler:
    def put(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
        need(c.board, Mode.CONFIGURATION)
        channel = channel_of(n)
        getattr(c.board, values)[kind, channel] = float(np.float32(number(a)))
        bit = 4 * (kind == "DAC") + 2 * channel + (values == "offsets")
        return _calibrated(c.board, bit)

    return put


def _limit(side: str) -> Handler:
    def put(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
        need(c.board, Mode.CONFIGURATION)
        c.board.limits[channel_of(n), side] = float(np.float32(number(a)))
        return _calibrated(c.board, 8 + 2 * n[0] + (side == "UPPER"))

    return put


def _get_limit(side: str) -> Handler:
    return lambda c, n, _: short(c.board.limits.get((n[0], side), float("nan")))


def _calibrated(board: Board, bit: int) -> str:
    board.calibration_flags |= 1 << bit
    board.stop_tx(offsets=True)
    return "1"


def reset_calibration(c: Connection, _: tuple[int, ...], __: list[str]) -> str:
    """Defaults again."""
    board = c.board
    for key in board.scales:
        board.scales[key], board.offsets[key] = (1 / 32768 if key[0] == "ADC" else 1.0), 0.0
    board.calibration_flags = 0
    board.stop_tx(offsets=True)
    return "1"


def _log(c: Connection, _: tuple[int, ...], __: list[str]) -> None:
    c.send_log()


WAITING = (set_table, upload_main, upload_enable, upload_resync)
"""Handlers that wait for bytes on the data socket, and take the world's lock themselves if they need it."""

_SERVER: dict[str, Handler] = {
    "*CLS": lambda c, n, a: None,
    "*ESE?": lambda c, n, a: "0",
    "*ESR?": lambda c, n, a: "0",
    "*IDN?": lambda c, n, a: "CUSTOM,REDPITAYA,0,0.1",
    "*OPC": lambda c, n, a: None,
    "*OPC?": lambda c, n, a: "1",
    "*RST": lambda c, n, a: None,
    "*SRE?": lambda c, n, a: "0",
    "*STB?": lambda c, n, a: "0",
    "*TST?": lambda c, n, a: "0",
    "*WAI": lambda c, n, a: None,
    "SYSTem:ERRor?": lambda c, n, a: c.next_error(),
    "SYSTem:ERRor:NEXT?": lambda c, n, a: c.next_error(),
    "SYSTem:VERSion?": lambda c, n, a: "1999.0",
    "RP:VERsion:IMAGe?": lambda c, n, a: str(c.board.options.image_version),
    "RP:VERsion:IMaGe?": lambda c, n, a: str(c.board.options.image_version),
    "RP:VERsion:SERVer?": lambda c, n, a: str(c.board.options.server_version),
    "RP:MODe": set_mode,
    "RP:MODe?": lambda c, n, a: quoted(c.board.mode.value),
    "RP:LOG?": _log,
    "RP:PERF?": lambda c, n, a: None,
    "RP:STATus?": lambda c, n, a: str(c.board.status()),
    "RP:STATus:OVERwritten?": lambda c, n, a: str(c.board.status() & 1),
    "RP:STATus:CORRupted?": lambda c, n, a: str(c.board.status() >> 1 & 1),
    "RP:STATus:LOSTSteps?": lambda c, n, a: str(c.board.status() >> 2 & 1),
    "RP:WatchDogMode": _set_word("watchdog", "ON", "OFF"),
    "RP:WatchDogMode?": lambda c, n, a: quoted(c.board.words["watchdog"]),
    "RP:InstantReset:MODe": _set_word("instant_reset", "ON", "OFF"),
    "RP:InstantReset:MODe?": lambda c, n, a: quoted(c.board.words["instant_reset"]),
    "RP:InstantReset:STATus?": lambda c, n, a: _on_off(c.board.reset_pin),
    "RP:InstantReset:TRIGgered?": lambda c, n, a: _on_off(c.board.reset_latched),
    "RP:COUnter:SAMPlesperstep": _set_number("counter", sequence=True),
    "RP:COUnter:SAMPlesperstep?": lambda c, n, a: str(c.board.numbers["counter"]),
}

_OUTPUT: dict[str, Handler] = {
    "RP:DAC:CHannel#:COMPonent#:AMPlitude": set_amplitude,
    "RP:DAC:CHannel#:COMPonent#:AMPlitude?": _get_component("amplitude_v"),
    "RP:DAC:CHannel#:COMPonent#:FREQuency": set_frequency,
    "RP:DAC:CHannel#:COMPonent#:FREQuency?": _get_component("frequency_hz"),
    "RP:DAC:CHannel#:COMPonent#:PHAse": set_phase,
    "RP:DAC:CHannel#:COMPonent#:PHAse?": _get_component("phase_rad"),
    "RP:DAC:CHannel#:COMPonent#:SIGnaltype": set_signal,
    "RP:DAC:CHannel#:COMPonent#:SIGnaltype?": _get_component("signal"),
    "RP:DAC:CHannel#:OFFset": set_offset,
    "RP:DAC:CHannel#:OFFset?": lambda c, n, a: exact(c.board.registers.outputs[channel_of(n)].offset_v),
    "RP:DAC:CHannel#:AWG": set_table,
    "RP:DAC:CHannel#:RAMPing": set_ramp,
    "RP:DAC:CHannel#:RAMPing?": lambda c, n, a: exact(c.board.registers.outputs[channel_of(n)].ramp_s),
    "RP:DAC:CHannel#:RAMPing:ENaBle": enable_ramp,
    "RP:DAC:CHannel#:RAMPing:ENaBle?": lambda c, n, a: _on_off(c.board.registers.outputs[channel_of(n)].ramp_enabled),
    "RP:DAC:CHannel#:RAMPing:DoWN": ramp_down,
    "RP:DAC:CHannel#:RAMPing:DoWN?": lambda c, n, a: _on_off(c.board.registers.outputs[channel_of(n)].ramp_down),
    "RP:DAC:RAMPing:STATus?": ramp_status,
    "RP:DAC:SEQ:SAMPlesperstep": set_step,
    "RP:DAC:SEQ:SAMPlesperstep?": lambda c, n, a: str(c.board.sequence.clocks_per_step // c.board.decimation),
    "RP:DAC:SEQ:CHan": set_channels,
    "RP:DAC:SEQ:CHan?": lambda c, n, a: str(c.board.sequence.channels),
    "RP:DAC:SEQ:LUT": upload_main,
    "RP:DAC:SEQ:LUT:ENaBle": upload_enable,
    "RP:DAC:SEQ:LUT:ReSYNC": upload_resync,
    "RP:DAC:SEQ:LUT:UP": _upload_ramp(down=False),
    "RP:DAC:SEQ:LUT:DOWN": _upload_ramp(down=True),
    "RP:DAC:SEQ:SET": set_sequence,
    "RP:DAC:SEQ:CLEAR": clear_sequence,
}

_INPUT: dict[str, Handler] = {
    "RP:ADC:DECimation": set_decimation,
    "RP:ADC:DECimation?": lambda c, n, a: str(c.board.decimation),
    "RP:ADC:FIREnabled": set_fir,
    "RP:ADC:FIREnabled?": lambda c, n, a: str(int(c.board.fir)),
    "RP:ADC:WP?": lambda c, n, a: str(c.board.write_pointer()),
    "RP:ADC:BUFfer:Size?": lambda c, n, a: str(RING),
    "RP:ADC:DATa?": read_simple,
    "RP:ADC:DATa:PIPElined?": read_pipelined,
    "RP:ADC:DATa:SToP?": lambda c, n, a: str(int(c.stop_sending())),
    "RP:TRIGger": set_trigger,
    "RP:TRIGger?": lambda c, n, a: _on_off(c.board.triggered),
    "RP:TRIGger:MODe": set_trigger_mode,
    "RP:TRIGger:MODe?": lambda c, n, a: quoted(c.board.trigger_mode),
    "RP:TRIGger:PROP": set_propagation,
    "RP:TRIGger:PROP?": lambda c, n, a: _on_off(c.board.propagate),
    "RP:TRIGger:ALiVe": set_keep_alive,
    "RP:TRIGger:ALiVe?": lambda c, n, a: _on_off(c.board.keep_alive),
    "RP:CounterTrigger:ENable": _set_counter_trigger("enabled"),
    "RP:CounterTrigger:ENable?": lambda c, n, a: _on_off(c.board.counter_trigger["enabled"]),
    "RP:CounterTrigger:ARM": _set_counter_trigger("armed"),
    "RP:CounterTrigger:ARM?": lambda c, n, a: _on_off(c.board.counter_trigger["armed"]),
    "RP:CounterTrigger:RESet": _set_counter_trigger("reset"),
    "RP:CounterTrigger:RESet?": lambda c, n, a: _on_off(c.board.counter_trigger["reset"]),
    "RP:CounterTrigger:PREsamples": _set_number("presamples"),
    "RP:CounterTrigger:PREsamples?": lambda c, n, a: str(c.board.numbers["presamples"]),
    "RP:CounterTrigger:COUNTer:LAst?": lambda c, n, a: "0",
    "RP:CounterTrigger:COUNTer:REFerence": _set_number("reference"),
    "RP:CounterTrigger:COUNTer:REFerence?": lambda c, n, a: str(c.board.numbers["reference"]),
    "RP:CounterTrigger:SouRCe:TYPe": _set_word("source_type", "DIO", "ADC"),
    "RP:CounterTrigger:SouRCe:TYPe?": lambda c, n, a: quoted(c.board.words["source_type"]),
    "RP:CounterTrigger:SouRCe:CHANnel": set_source,
    "RP:CounterTrigger:SouRCe:CHANnel?": lambda c, n, a: quoted(c.board.words["source"]),
}

_CALIBRATION: dict[str, Handler] = {
    f"RP:CALib:{kind}:CHannel#:{keyword}{'?' if query else ''}": (_get_calibration if query else _set_calibration)(
        kind, values
    )
    for kind in ("ADC", "DAC")
    for keyword, values in (("OFFset", "offsets"), ("SCAle", "scales"))
    for query in (False, True)
} | {
    "RP:CALib:DAC:CHannel#:LIMit:LOWer": _limit("LOWER"),
    "RP:CALib:DAC:CHannel#:LIMit:LOWer?": _get_limit("LOWER"),
    "RP:CALib:DAC:CHannel#:LIMit:UPper": _limit("UPPER"),
    "RP:CALib:DAC:CHannel#:LIMit:UPper?": _get_limit("UPPER"),
    "RP:CALib:FLAGs": lambda c, n, a: str(c.board.calibration_flags),
    "RP:CALib:RESet": reset_calibration,
}

COMMANDS: CommandTable[Handler] = CommandTable(
    _SERVER | _OUTPUT | _INPUT | _CALIBRATION | _pin_commands("N") | _pin_commands("P")
)
