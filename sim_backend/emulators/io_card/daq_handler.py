"""What the handlers of the I/O card's commands share: their arguments, their replies, and what they need of the server.

A handler gets the connection, the numbers in the header and the arguments, and returns the reply, None: it says
nothing.  `Code` is a negative reply.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable
from typing import Protocol

from .board import Board, Mode
from .registers import COMPONENTS, OUTPUTS

RANGE = -2
BAD_CHANNEL = -3
BAD_COMPONENT = -4
BAD_MODE = -5
MISSING = -6
NOT_CONFIGURABLE = -7
UNSPECIFIED = -1
NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
WHOLE = re.compile(r"[+-]?\d+")


class Code(Exception):
    """A refusal: the reply is its number."""

    def __init__(self, number: int) -> None:
        self.number = number


class Silence(Exception):
    """The parser gives up: no reply."""


class Connection(Protocol):
    """What a handler needs of the server."""

    board: Board
    errors: deque[str]

    def upload(self, count: int) -> bytes:
        """So many bytes from the data socket; fewer if the client disconnects."""

    def start_sending(self, start: int, count: int, chunk: int | None) -> None:
        """Send samples; chunk None: at once and without records."""

    def busy(self, seconds: float) -> None:
        """The server does nothing else for so long, s; without the world's lock."""

    def stop_sending(self) -> bool:
        """End a pipelined read; True if there was one."""

    def send_log(self) -> None:
        """The log file on the data socket."""

    def send_performance(self) -> None:
        """The figures of the last record on the data socket, if samples are being sent."""


Handler = Callable[[Connection, tuple[int, ...], list[str]], str | None]


def number(arguments: list[str], place: int = 0) -> float:
    """A number.  Raises Code if it is missing or is none, Silence if there is a blank instead of a comma."""
    return float(_text(arguments, place))


def whole(arguments: list[str], place: int = 0) -> int:
    """A whole number: the leading digits of a number, whatever follows them."""
    digits = WHOLE.match(_text(arguments, place))
    if digits is None:
        raise Code(MISSING)
    return int(digits[0])


def _text(arguments: list[str], place: int) -> str:
    text = arguments[place] if place < len(arguments) else ""
    if len(text.split()) > 1:
        raise Silence
    if not NUMBER.fullmatch(text):
        raise Code(MISSING)
    return text


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
    if board.mode is not Mode.CONFIGURATION or board.sequence.busy:
        raise Code(NOT_CONFIGURABLE)


def channel_of(numbers: tuple[int, ...]) -> int:
    """A DAC or ADC channel."""
    if numbers[0] >= OUTPUTS:
        raise Code(BAD_CHANNEL)
    return numbers[0]


def component_of(numbers: tuple[int, ...], most: int = COMPONENTS) -> tuple[int, int]:
    """Channel and component, 0..most."""
    channel = channel_of(numbers)
    if numbers[1] > most:
        raise Code(BAD_COMPONENT)
    return channel, numbers[1]


def on_off(level: bool) -> str:
    """A level as the server writes it."""
    return quoted("ON" if level else "OFF")
