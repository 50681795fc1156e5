"""A serial controller: every command has one answer, errors are `ERR number,"text"`."""

from __future__ import annotations

import math
import re

from drivers.errors import DeviceError, DeviceFault, DeviceProtocolError, DeviceStateError
from drivers.exchange import Exchange

ERRORS: dict[int, type[DeviceError]] = {
    1: DeviceProtocolError,
    2: DeviceProtocolError,
    3: DeviceStateError,
    4: DeviceFault,
}
UNKNOWN = 1
ERROR = re.compile(r'ERR (\d+),"(.*)"')


def query(exchange: Exchange, question: str) -> str:
    """The answer.  Raises DeviceStateError (not now), DeviceFault, DeviceProtocolError (unknown command, argument)."""
    answer = exchange.ask(question)
    found = ERROR.fullmatch(answer)
    if found:
        kind = ERRORS.get(int(found[1]), DeviceProtocolError)
        remedy = "check that this is the right device on the right port"
        raise kind(f"{question!r} was refused", where=exchange.where, why=found[2], remedy=remedy)
    return answer


def knows(exchange: Exchange, question: str) -> bool:
    """False if the controller calls this an unknown command.  Raises DeviceTimeout, DeviceLost."""
    found = ERROR.fullmatch(exchange.ask(question))
    return found is None or int(found[1]) != UNKNOWN


def command(exchange: Exchange, text: str) -> None:
    """A command that answers OK; errors as in `query`."""
    answer = query(exchange, text)
    if answer != "OK":
        raise senseless(exchange, text, answer)


def numbers(exchange: Exchange, question: str) -> tuple[float, ...]:
    """An answer of numbers separated by commas."""
    answer = query(exchange, question)
    try:
        found = tuple(float(part) for part in answer.split(","))
    except ValueError:
        found = (math.nan,)
    if not all(map(math.isfinite, found)):
        raise senseless(exchange, question, answer)
    return found


def flag(exchange: Exchange, question: str) -> bool:
    """An answer of 1 or 0."""
    answer = query(exchange, question)
    if answer not in ("0", "1"):
        raise senseless(exchange, question, answer)
    return answer == "1"


def senseless(exchange: Exchange, question: str, answer: str) -> DeviceProtocolError:
    """The error for an answer that does not fit."""
    return DeviceProtocolError(
        f"the answer to {question!r} makes no sense",
        where=exchange.where,
        why=f"it is {answer[:60]!r}",
        remedy="check that this is the right device on the right port",
    )
