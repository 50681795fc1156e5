"""The commands of RedPitayaDAQServer that the driver uses, and what each answers.

The server says nothing at all to a header it does not know, so one that is not in this table is never sent.  Headers
are full words: the server's short forms are irregular.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from enum import StrEnum

from drivers.errors import DeviceProtocolError
from drivers.red_pitaya.emergency import EMERGENCY
from drivers.red_pitaya.layout import pin_header
from drivers.red_pitaya.options import CardTable
from drivers.red_pitaya.output_readback import SINES

# bits of the server's status
TRIGGERED = 8
RUNNING = 16
ENDED = (
    "RP:STATUS?",
    EMERGENCY,
    "RP:ADC:WP?",
    "RP:MODE?",
)  # questions at the end of a shot
TO_CONFIGURE = ("RP:MODE ACQUISITION", "RP:TRIGGER OFF", "RP:TRIGGER:ALIVE OFF", "RP:MODE CONFIGURATION")
"""The trigger must be off to leave ACQUISITION."""
SENDING = "TRANSMISSION"  # the mode of a server that sends samples, or takes the commands that came meanwhile


class Reply(StrEnum):
    """Kinds of answers: DONE `1` or an error code, INTEGER and NUMBER as text, WORD in double quotes, FLAG `1`, `0`,
    `"ON"` or `"OFF"`, LINE as it is."""

    DONE = "done"
    INTEGER = "integer"
    NUMBER = "number"
    WORD = "word"
    FLAG = "flag"
    LINE = "line"


REPLIES = {
    "*IDN?": Reply.LINE,
    "RP:VERSION:IMAGE?": Reply.INTEGER,
    "RP:VERSION:SERVER?": Reply.INTEGER,
    "RP:CALIB:ADC:CHANNEL#:SCALE?": Reply.NUMBER,
    "RP:CALIB:ADC:CHANNEL#:OFFSET?": Reply.NUMBER,
    "RP:CALIB:DAC:CHANNEL#:SCALE?": Reply.NUMBER,
    "RP:CALIB:DAC:CHANNEL#:OFFSET?": Reply.NUMBER,
    "RP:CALIB:DAC:CHANNEL#:LIMIT:LOWER?": Reply.NUMBER,
    "RP:CALIB:DAC:CHANNEL#:LIMIT:UPPER?": Reply.NUMBER,
    "RP:CALIB:FLAGS": Reply.INTEGER,
    "RP:MODE": Reply.DONE,
    "RP:MODE?": Reply.WORD,
    "RP:ADC:DECIMATION": Reply.DONE,
    "RP:ADC:DECIMATION?": Reply.INTEGER,
    "RP:ADC:FIRENABLED": Reply.DONE,
    "RP:ADC:WP?": Reply.INTEGER,
    "RP:ADC:DATA?": Reply.DONE,
    "RP:ADC:DATA:PIPELINED?": Reply.DONE,
    "RP:TRIGGER": Reply.DONE,
    "RP:TRIGGER?": Reply.WORD,
    "RP:TRIGGER:MODE": Reply.DONE,
    "RP:TRIGGER:PROP": Reply.DONE,
    "RP:TRIGGER:ALIVE": Reply.DONE,
    "RP:COUNTERTRIGGER:ENABLE": Reply.DONE,
    "RP:INSTANTRESET:MODE": Reply.DONE,
    "RP:INSTANTRESET:STATUS?": Reply.FLAG,
    "RP:INSTANTRESET:TRIGGERED?": Reply.FLAG,
    "RP:COUNTER:SAMPLESPERSTEP": Reply.DONE,
    "RP:STATUS?": Reply.INTEGER,
    "RP:DAC:CHANNEL#:OFFSET": Reply.DONE,
    "RP:DAC:CHANNEL#:OFFSET?": Reply.NUMBER,
    "RP:DAC:CHANNEL#:RAMPING:ENABLE": Reply.DONE,
    "RP:DAC:CHANNEL#:COMPONENT#:AMPLITUDE": Reply.DONE,
    "RP:DAC:CHANNEL#:COMPONENT#:AMPLITUDE?": Reply.NUMBER,
    "RP:DAC:CHANNEL#:COMPONENT#:FREQUENCY": Reply.DONE,
    "RP:DAC:CHANNEL#:COMPONENT#:PHASE": Reply.DONE,
    "RP:DAC:CHANNEL#:COMPONENT#:SIGNALTYPE": Reply.DONE,
    "RP:DAC:SEQ:SAMPLESPERSTEP": Reply.DONE,
    "RP:DAC:SEQ:CHAN": Reply.DONE,
    "RP:DAC:SEQ:LUT": Reply.DONE,
    "RP:DAC:SEQ:LUT:ENABLE": Reply.DONE,
    "RP:DAC:SEQ:LUT:RESYNC": Reply.DONE,
    "RP:DAC:SEQ:LUT:UP": Reply.DONE,
    "RP:DAC:SEQ:LUT:DOWN": Reply.DONE,
    "RP:DAC:SEQ:SET": Reply.DONE,
    "RP:DIO:PIN#:SIDEP": Reply.DONE,
    "RP:DIO:PIN#:SIDEN": Reply.DONE,
    "RP:DIO:PIN#:SIDEP?": Reply.WORD,
    "RP:DIO:PIN#:SIDEN?": Reply.WORD,
    "RP:DIO:PIN#:SIDEP:DIR": Reply.DONE,
    "RP:DIO:PIN#:SIDEN:DIR": Reply.DONE,
    "RP:DIO:PIN#:SIDEP:HBRIDGE": Reply.DONE,
    "RP:DIO:PIN#:SIDEN:HBRIDGE": Reply.DONE,
}

FLAGS = {"1": 1, "0": 0, "ON": 1, "OFF": 0}
REFUSALS = {
    0: "refused",
    -1: "refused without a reason",
    -2: "value out of range",
    -3: "no such channel or pin",
    -4: "no such component",
    -5: "wrong server mode",
    -6: "argument missing or unreadable",
    -7: "the sequence cannot be configured now",
}


def register_commands(table: CardTable, outputs: Sequence[str], inputs: Sequence[str], *, is_last: bool) -> list[str]:
    """Commands for the registers that keep their values over a reconnect, whichever client set them.

    outputs, inputs: DIO pins; is_last: the last board passes no trigger on.  The pulses of the counter would be joined
    onto DIO2_N, DIO3_N and DIO4_N.
    """
    return [
        "RP:ADC:FIRENABLED ON",
        f"RP:ADC:DECIMATION {table.decimation}",
        f"RP:TRIGGER:MODE {table.trigger.upper()}",
        f"RP:TRIGGER:PROP {'OFF' if is_last else 'ON'}",
        "RP:COUNTERTRIGGER:ENABLE OFF",
        "RP:COUNTER:SAMPLESPERSTEP 0",
        f"RP:INSTANTRESET:MODE {'ON' if table.instant_reset else 'OFF'}",
        *(f"RP:DAC:CHANNEL{o}:RAMPING:ENABLE OFF" for o in (0, 1)),
        *(f"RP:DAC:CHANNEL{o}:COMPONENT{c}:SIGNALTYPE SINE" for o, c in SINES),
        *(f"{pin_header(pin)}:HBRIDGE OFF" for pin in outputs),  # or it carries pulses, not a level
        *(f"{pin_header(pin)}:DIR OUT" for pin in outputs),
        *(f"{pin_header(pin)}:DIR IN" for pin in inputs),
    ]


def reply_kind(command: str) -> Reply:
    """What the server answers to a command line.  Raises KeyError for one that is not in the table."""
    header = command.split(" ", 1)[0]
    return REPLIES[re.sub(r"(CHANNEL|COMPONENT|PIN)\d", r"\1#", header)]


def parse(command: str, line: str, where: str) -> str | int | float:
    """The value in a reply line.  Raises DeviceProtocolError if the server refused or the line makes no sense."""
    kind = reply_kind(command)
    try:
        if kind is Reply.DONE:
            return _done(command, int(line), where)
        if kind is Reply.INTEGER:
            return int(line)
        if kind is Reply.NUMBER:
            return float(line)
    except ValueError:
        raise senseless(command, line, where) from None
    if kind is Reply.FLAG:
        if line.strip('"') not in FLAGS:
            raise senseless(command, line, where)
        return FLAGS[line.strip('"')]
    if kind is Reply.WORD:
        if len(line) < 2 or line[0] != '"' or line[-1] != '"':
            raise senseless(command, line, where)
        return line[1:-1]
    return line


def _done(command: str, code: int, where: str) -> int:
    if code > 0:
        return code
    raise DeviceProtocolError(
        f"the card refused {command!r}",
        where=where,
        why=f"{REFUSALS.get(code, 'unknown code')} ({code})",
        remedy="stop the card, which connects again; if it happens again, check the version of its server",
    )


def senseless(command: str, line: str, where: str) -> DeviceProtocolError:
    """The error for a reply that does not fit its command."""
    return DeviceProtocolError(
        f"the answer to {command!r} makes no sense",
        where=where,
        why=f"it is {line[:80]!r}",
        remedy="stop the card, which connects again",
    )
