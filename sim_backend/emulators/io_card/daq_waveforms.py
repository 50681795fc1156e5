"""Commands of the I/O card: waveforms, offsets, tables and ramps."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .board import Board, Mode
from .daq_handler import (
    BAD_CHANNEL,
    RANGE,
    Code,
    Connection,
    Handler,
    channel_of,
    component_of,
    exact,
    need,
    number,
    on_off,
    quoted,
    word,
)
from .registers import (
    AMPLITUDE_CODES,
    AWG_SAMPLES,
    BASE_HZ,
    COMPONENTS,
    FREQUENCY_STEP_HZ,
    OFFSET_CODES,
    OUTPUTS,
    PHASE_STEPS,
    SIGNALS,
)
from .sequence import ServerCrash

SLOWEST_HZ = 0.03


def floats(c: Connection, count: int) -> NDArray[np.float32]:
    """So many float32 from the data socket."""
    raw = c.upload(4 * count)
    return np.frombuffer(raw[: len(raw) // 4 * 4], "<f4")


def set_amplitude(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
    """V, 0 ... 1/scale; that of the fourth component has no effect."""
    channel, component = component_of(n)
    volts = number(a)
    if volts < 0:
        raise Code(RANGE)
    return _component(c.board, channel, component, amplitude_v=_put_out(c.board, channel, volts, AMPLITUDE_CODES))


def get_amplitude(c: Connection, n: tuple[int, ...], _: list[str]) -> str:
    """V: the register divided by the scale; of a channel or component that is not there, the code for that as if it
    were the register (16 bits without sign)."""
    try:
        channel, component = component_of(n)
    except Code as refusal:
        scale = c.board.scales.get(("DAC", n[0]), 1.0)
        return exact((refusal.number % 2**16) / (AMPLITUDE_CODES / 2) / scale / 2)
    return _answer(c.board, channel, c.board.registers.outputs[channel].components[component].amplitude_v)


def _put_out(board: Board, channel: int, volts: float, codes: int) -> float:
    """V that a register of so many codes makes of it.  Raises Code if it is too much for it."""
    scale = board.scales["DAC", channel]
    if abs(volts * scale) > 1:
        raise Code(RANGE)
    level = 0 if math.isnan(scale) else int(volts * scale * codes)
    return level / codes / scale if level else 0.0


def _answer(board: Board, channel: int, volts: float) -> str:
    """A register divided by the scale; of a memory that makes no sense nothing comes out, and this is no number."""
    scale = board.scales["DAC", channel]
    return "nan" if scale == 0 or math.isnan(scale) else exact(volts)


def set_frequency(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
    """Hz, 0.03 ... 125 MHz."""
    channel, component = component_of(n)
    hz = number(a)
    if not SLOWEST_HZ <= hz < BASE_HZ:
        raise Code(RANGE)
    return _component(c.board, channel, component, frequency_hz=round(hz / FREQUENCY_STEP_HZ) * FREQUENCY_STEP_HZ)


def set_phase(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
    """rad, within one turn, and truncated."""
    channel, component = component_of(n)
    turn = np.fmod(number(a), 2 * np.pi)
    steps = np.floor((turn + 2 * np.pi if turn < 0 else turn) / (2 * np.pi) * PHASE_STEPS)
    return _component(c.board, channel, component, phase_rad=float(steps / PHASE_STEPS * 2 * np.pi))


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
        try:
            channel, component = component_of(n, COMPONENTS - 1 if name == "signal" else COMPONENTS)
        except Code as refusal:
            if name == "signal":
                raise ServerCrash from None  # a name that was never set
            return exact(refusal.number)
        value = getattr(c.board.registers.outputs[channel].components[component], name)
        return quoted(value) if name == "signal" else exact(value)

    return get


def set_offset(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
    """V, up to 1/scale in both directions."""
    channel = channel_of(n)
    volts = number(a)
    return _output(c.board, channel, offset_v=_put_out(c.board, channel, volts, OFFSET_CODES))


def get_offset(c: Connection, n: tuple[int, ...], _: list[str]) -> str:
    """V, as `get_amplitude`."""
    if n[0] >= OUTPUTS:
        return exact(BAD_CHANNEL / OFFSET_CODES)
    return _answer(c.board, n[0], c.board.registers.outputs[n[0]].offset_v)


def _output(board: Board, channel: int, **changes: object) -> str:
    output = replace(board.registers.outputs[channel], **changes)  # type: ignore[arg-type]
    board.write(board.registers.with_output(channel, output))
    return "1"


def set_table(c: Connection, n: tuple[int, ...], _: list[str]) -> str:
    """16384 float32 on the data socket, taken whatever the channel; the limit is that of the first channel's scale."""
    table = floats(c, AWG_SAMPLES).astype(np.float64)
    highest = np.max(np.abs(table * c.board.scales["DAC", 0]), initial=0.0)
    if n[0] >= OUTPUTS or table.size < AWG_SAMPLES or not highest <= 1:
        return "0"
    with c.board.cards.world.lock:
        return _output(c.board, n[0], table=table)


def set_ramp(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
    """Length of the ramp, s; the register holds its inverse."""
    channel = channel_of(n)
    seconds = number(a)
    hz = 1 / seconds if seconds else np.inf
    if not SLOWEST_HZ <= hz < BASE_HZ:
        raise Code(RANGE)
    return _output(c.board, channel, ramp_s=1 / (round(hz / FREQUENCY_STEP_HZ) * FREQUENCY_STEP_HZ))


def get_ramp(c: Connection, n: tuple[int, ...], _: list[str]) -> str:
    """Length of the ramp, s; of a register that was never written: infinite."""
    if n[0] >= OUTPUTS:
        return exact(1 / BAD_CHANNEL)
    return exact(c.board.registers.outputs[n[0]].ramp_s or np.inf)


def enable_ramp(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
    """ON or OFF."""
    need(c.board, Mode.CONFIGURATION)
    return _output(c.board, channel_of(n), ramp_enabled=word(a, "ON", "OFF") == "ON", ramp_down=False)


def get_ramp_enabled(c: Connection, n: tuple[int, ...], _: list[str]) -> str:
    """ON or OFF; of a channel that is not there, a name that was never set."""
    if n[0] >= OUTPUTS:
        raise ServerCrash
    return on_off(c.board.registers.outputs[n[0]].ramp_enabled)


def ramp_down(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
    """Begin the way down; cannot be undone."""
    need(c.board, Mode.ACQUISITION, Mode.TRANSMISSION)
    channel = channel_of(n)
    on = word(a, "ON", "OFF") == "ON"
    return _output(c.board, channel, ramp_down=on or c.board.registers.outputs[channel].ramp_down)


def ramp_status(c: Connection, _: tuple[int, ...], __: list[str]) -> str:
    """Bit 0 enabled, bits 1-2: 0 normal, 1 done, 2 up, 3 down; the second output four bits higher."""
    status = 0
    for k, output in enumerate(c.board.registers.outputs):
        rising = c.board.triggered and c.board.elapsed() < output.ramp_s * c.board.rate_hz
        state = 3 if output.ramp_down else 2 if rising else 1 if c.board.triggered else 0
        status |= (1 | state << 1) << 4 * k if output.ramp_enabled else 0
    return str(status)


WAVEFORMS: dict[str, Handler] = {
    "RP:DAC:CHannel#:COMPonent#:AMPlitude": set_amplitude,
    "RP:DAC:CHannel#:COMPonent#:AMPlitude?": get_amplitude,
    "RP:DAC:CHannel#:COMPonent#:FREQuency": set_frequency,
    "RP:DAC:CHannel#:COMPonent#:FREQuency?": _get_component("frequency_hz"),
    "RP:DAC:CHannel#:COMPonent#:PHAse": set_phase,
    "RP:DAC:CHannel#:COMPonent#:PHAse?": _get_component("phase_rad"),
    "RP:DAC:CHannel#:COMPonent#:SIGnaltype": set_signal,
    "RP:DAC:CHannel#:COMPonent#:SIGnaltype?": _get_component("signal"),
    "RP:DAC:CHannel#:OFFset": set_offset,
    "RP:DAC:CHannel#:OFFset?": get_offset,
    "RP:DAC:CHannel#:AWG": set_table,
    "RP:DAC:CHannel#:RAMPing": set_ramp,
    "RP:DAC:CHannel#:RAMPing?": get_ramp,
    "RP:DAC:CHannel#:RAMPing:ENaBle": enable_ramp,
    "RP:DAC:CHannel#:RAMPing:ENaBle?": get_ramp_enabled,
    "RP:DAC:CHannel#:RAMPing:DoWN": ramp_down,
    "RP:DAC:CHannel#:RAMPing:DoWN?": lambda c, n, a: on_off(c.board.registers.outputs[channel_of(n)].ramp_down),
    "RP:DAC:RAMPing:STATus?": ramp_status,
}
