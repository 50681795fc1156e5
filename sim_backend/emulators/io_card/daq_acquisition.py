"""Commands of the I/O card: decimation, trigger, reading."""

from __future__ import annotations

from .board import Mode
from .daq_handler import RANGE, Code, Connection, Handler, need, on_off, quoted, whole, word
from .sample_ring import RING

WORD = 2**16


def set_decimation(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """Even, 8 ... 8192, of which the server sees 16 bits."""
    need(c.board, Mode.CONFIGURATION)
    decimation = whole(a) % WORD  # a register of 16 bits
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
    """ON or OFF; OFF ends keep-alive as well, unless another card's trigger is still on."""
    need(c.board, Mode.ACQUISITION)
    c.board.trigger_on = word(a, "ON", "OFF") == "ON"
    c.board.cards.update_trigger()
    if not c.board.trigger_on:
        c.board.keep_alive = c.board.triggered
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
    """ON or OFF; OFF is answered with success but comes to nothing while the trigger is on."""
    need(c.board, Mode.ACQUISITION)
    c.board.keep_alive = word(a, "ON", "OFF") == "ON" or (c.board.keep_alive and c.board.triggered)
    return "1"


ACQUISITION: dict[str, Handler] = {
    "RP:ADC:DECimation": set_decimation,
    "RP:ADC:DECimation?": lambda c, n, a: str(c.board.decimation),
    "RP:ADC:FIREnabled": set_fir,
    "RP:ADC:FIREnabled?": lambda c, n, a: on_off(c.board.fir),
    "RP:ADC:WP?": lambda c, n, a: str(c.board.write_pointer()),
    "RP:ADC:BUFfer:Size?": lambda c, n, a: str(RING),
    "RP:ADC:DATa?": read_simple,
    "RP:ADC:DATa:PIPElined?": read_pipelined,
    "RP:ADC:DATa:SToP?": lambda c, n, a: str(int(c.stop_sending())),
    "RP:TRIGger": set_trigger,
    "RP:TRIGger?": lambda c, n, a: on_off(c.board.triggered),
    "RP:TRIGger:MODe": set_trigger_mode,
    "RP:TRIGger:MODe?": lambda c, n, a: quoted(c.board.trigger_mode),
    "RP:TRIGger:PROP": set_propagation,
    "RP:TRIGger:PROP?": lambda c, n, a: on_off(c.board.propagate),
    "RP:TRIGger:ALiVe": set_keep_alive,
    "RP:TRIGger:ALiVe?": lambda c, n, a: on_off(c.board.keep_alive),
}
