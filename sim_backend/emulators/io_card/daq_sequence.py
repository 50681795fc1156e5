"""Commands of the I/O card: the sequence and its uploads."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .daq_handler import NOT_CONFIGURABLE, RANGE, Code, Connection, Handler, configurable, whole
from .daq_waveforms import floats
from .registers import OUTPUTS

CLOCKS = 2**32


def set_step(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """Samples per step, whatever number; kept in clocks of 125 MHz, in a register of 32 bits."""
    configurable(c.board)
    c.board.sequence.clocks_per_step = whole(a) * c.board.decimation % CLOCKS
    c.board.sequence.let_go()
    return "1"


def get_step(c: Connection, _: tuple[int, ...], __: list[str]) -> str:
    """The register, taken for a number with a sign, in samples."""
    clocks = c.board.sequence.clocks_per_step
    return str(int((clocks - CLOCKS if clocks >= CLOCKS // 2 else clocks) / c.board.decimation))


def set_channels(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """How many channels the tables have."""
    configurable(c.board)
    c.board.sequence.configured()
    c.board.sequence.channels = whole(a)
    c.board.sequence.let_go()
    return "1"


def _shape(c: Connection, a: list[str], least: int) -> tuple[int, int]:
    """Steps and repetitions of an upload, so many at least."""
    steps, repetitions = whole(a, 0), whole(a, 1)
    configurable(c.board)
    if c.board.sequence.channels <= 0:
        raise Code(NOT_CONFIGURABLE)
    if min(steps, repetitions) < least:
        raise Code(RANGE)
    return steps, repetitions


def _table(c: Connection, steps: int) -> NDArray[np.float32]:
    channels = c.board.sequence.channels
    """The rest is zero if the data connection ends before: the server does not look at that."""
    values = np.zeros(steps * channels, np.float32)
    came = floats(c, values.size)
    values[: came.size] = came
    return values.reshape(steps, channels)


def upload_main(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """`SEQ:LUT steps,repetitions` and the values."""
    steps, repetitions = _shape(c, a, 1)
    c.board.sequence.upload(_table(c, steps), repetitions)
    return "1"


def _upload_ramp(c: Connection, a: list[str], *, down: bool) -> str:
    steps, repetitions = _shape(c, a, 0)
    c.board.sequence.upload_ramp(_table(c, steps), repetitions, down=down)
    return "1"


def upload_up(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """`SEQ:LUT:UP steps,repetitions` and the values: played before."""
    return _upload_ramp(c, a, down=False)


def upload_down(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """`SEQ:LUT:DOWN steps,repetitions` and the values: played after."""
    return _upload_ramp(c, a, down=True)


def _bits(c: Connection, channels: int) -> NDArray[np.bool_]:
    configurable(c.board)
    steps = c.board.sequence.steps()
    if not steps or channels <= 0:
        raise Code(NOT_CONFIGURABLE)
    raw = c.upload(steps * channels).ljust(steps * channels, b"\0")
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
    """`SEQ:SET`, which writes the ring of steps; nothing else is served meanwhile."""
    board = c.board
    with board.cards.world.lock:
        configurable(board)
        accesses = board.sequence.accesses()
    c.busy(accesses * board.options.memory_access_s)
    with board.cards.world.lock:
        board.sequence.set(board.sequence.clocks_per_step // board.decimation)
        board.sequence.lost_steps = board.triggered  # the step counter is far ahead of what was filled
    return "1"


def clear_sequence(c: Connection, _: tuple[int, ...], __: list[str]) -> str:
    """`SEQ:CLEAR`."""
    configurable(c.board)
    c.board.sequence.clear()
    return "1"


SEQUENCE: dict[str, Handler] = {
    "RP:DAC:SEQ:SAMPlesperstep": set_step,
    "RP:DAC:SEQ:SAMPlesperstep?": get_step,
    "RP:DAC:SEQ:CHan": set_channels,
    "RP:DAC:SEQ:CHan?": lambda c, n, a: str(c.board.sequence.channels),
    "RP:DAC:SEQ:LUT": upload_main,
    "RP:DAC:SEQ:LUT:ENaBle": upload_enable,
    "RP:DAC:SEQ:LUT:ReSYNC": upload_resync,
    "RP:DAC:SEQ:LUT:UP": upload_up,
    "RP:DAC:SEQ:LUT:DOWN": upload_down,
    "RP:DAC:SEQ:SET": set_sequence,
    "RP:DAC:SEQ:CLEAR": clear_sequence,
}

UPLOADS = (upload_main, upload_enable, upload_resync, upload_up, upload_down)
