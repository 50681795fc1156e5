"""Pins that the host sets by command and reads back at the pad, which cable and load may delay."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from drivers.red_pitaya.connection import Connection, Value
from drivers.red_pitaya.layout import pin_header

Ask = Callable[..., list[Value]]

PAD_S = 0.05  # a pad that has not followed by then is too late for a shot
LOW_S = 0.3  # and one that is still high by then stays high


def level(high: bool) -> str:
    """A level as the server writes it."""
    return "ON" if high else "OFF"


def set_pin(ask: Ask, pin: str, *, high: bool) -> tuple[str, int]:
    """Set a pin and read it back: (the level at the pad, the sample at which it was read).

    The sample is that of the recording, 0 if there is none.  Errors as in `Connection.ask`.
    """
    header = pin_header(pin)
    deadline = time.monotonic() + PAD_S
    _, found, written = ask(f"{header} {level(high)}", f"{header}?", "RP:ADC:WP?")
    while found != level(high) and time.monotonic() < deadline:
        found, written = ask(f"{header}?", "RP:ADC:WP?")
    return str(found), int(written)


def low_levels(connection: Connection, pins: Sequence[str], timeout_s: float) -> list[str]:
    """Levels at the pads of pins that were set low: "OFF" each, unless one does not follow.

    timeout_s: for each round of answers.  Errors as in `Connection.ask`.
    """
    deadline = time.monotonic() + LOW_S
    questions = [f"{pin_header(pin)}?" for pin in pins]
    while True:
        found = [str(each) for each in connection.ask_all(questions, timeout_s)]
        if all(each == level(False) for each in found) or time.monotonic() >= deadline:
            return found
