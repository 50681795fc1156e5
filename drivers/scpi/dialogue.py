"""Answers of an SCPI device, read with the words of its table."""

from __future__ import annotations

import math
import re

from drivers.errors import DeviceProtocolError
from drivers.exchange import Exchange
from drivers.scpi.options import Words

NO_NUMBER = 9.9e37
NUMBERED = re.compile(r'\s*([+-]?\d+)\s*(?:,\s*"?(.*?)"?\s*)?')


def yes(exchange: Exchange, question: str, words: Words) -> bool:
    """A yes or no.  Raises DeviceProtocolError for anything else."""
    answer = exchange.ask(question)
    for means, known in ((True, words.yes), (False, words.no)):
        if answer.upper() in (word.upper() for word in known):
            return means
    raise senseless(exchange, question, answer)


def number(exchange: Exchange, question: str) -> float:
    """A number.

    Raises DeviceProtocolError for anything else, also for what SCPI gives in the place of a number: 9.91E37 for NaN and
    9.9E37 for infinity (SCPI 1999, volume 1, section 7.2.1.4).
    """
    answer = exchange.ask(question)
    try:
        found = float(answer)
    except ValueError:
        found = math.nan
    if not abs(found) < NO_NUMBER:
        raise senseless(exchange, question, answer)
    return found


def fault_of(exchange: Exchange, question: str, words: Words) -> str | None:
    """What a device says of its health, None if it is healthy: by number, or in words where the table has them."""
    if not words.healthy:
        return numbered(exchange, question)
    answer = exchange.ask(question)
    return None if answer.upper() in (word.upper() for word in words.healthy) else answer


def numbered(exchange: Exchange, question: str) -> str | None:
    """The text of `number,"text"`; None for number 0."""
    answer = exchange.ask(question)
    found = NUMBERED.fullmatch(answer)
    if found is None:
        raise senseless(exchange, question, answer)
    return None if int(found[1]) == 0 else found[2] or f"number {found[1]}"


def senseless(exchange: Exchange, question: str, answer: str) -> DeviceProtocolError:
    """The error for an answer that does not fit."""
    return DeviceProtocolError(
        f"the answer to {question!r} makes no sense",
        where=exchange.where,
        why=f"it is {answer[:60]!r}",
        remedy="check the table of commands in the platform file",
    )
