"""Commands of the I/O card: what its EEPROM holds."""

from __future__ import annotations

import numpy as np

from .board import Board, Mode
from .daq_handler import Connection, Handler, channel_of, need, number, short


def _get_calibration(kind: str, values: str) -> Handler:
    def get(c: Connection, n: tuple[int, ...], _: list[str]) -> str:
        return short(getattr(c.board, values).get((kind, n[0]), float("nan")))

    return get


def _set_calibration(kind: str, values: str) -> Handler:
    def put(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
        need(c.board, Mode.CONFIGURATION)
        value = float(np.float32(number(a)))
        channel = channel_of(n)
        getattr(c.board, values)[kind, channel] = value
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
        board.scales[key] = 1 / 32768 if key[0] == "ADC" else 1.0
        board.offsets[key] = 0.0
    board.calibration_flags = 0
    board.stop_tx(offsets=True)
    return "1"


CALIBRATION: dict[str, Handler] = {
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
