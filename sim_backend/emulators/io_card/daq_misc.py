"""Commands of the I/O card: the server itself, pins, and registers that only stay where they are."""

from __future__ import annotations

from .board import Mode
from .daq_handler import (
    BAD_CHANNEL,
    BAD_MODE,
    MISSING,
    Code,
    Connection,
    Handler,
    configurable,
    need,
    on_off,
    quoted,
    whole,
    word,
)
from .registers import PINS


def set_mode(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """`RP:MODe`."""
    mode = word(a, "CONFIGURATION", "ACQUISITION", "TRANSMISSION")
    need(c.board, Mode.CONFIGURATION, Mode.ACQUISITION)
    if mode == "TRANSMISSION":
        raise Code(BAD_MODE)
    c.board.mode = Mode(mode)
    return "1"


def _next_error(c: Connection, _: tuple[int, ...], __: list[str]) -> str:
    return c.errors.popleft() if c.errors else '0,"No error"'


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


def _set_bridge(side: str) -> Handler:
    def handle(c: Connection, n: tuple[int, ...], a: list[str]) -> str:
        c.board.pin_bridge[_pin(side, n)] = word(a, "ON", "OFF") == "ON"
        c.board.set_pins()
        return "1"

    return handle


def _pin_commands(side: str) -> dict[str, Handler]:
    head = f"RP:DIO:Pin#:Side{side}"
    return {
        f"{head}:DIR": _set_direction(side),
        f"{head}:DIR?": lambda c, n, a: quoted("OUT" if c.board.pin_out.get(_pin(side, n), True) else "IN"),
        f"{head}:HBridge": _set_bridge(side),
        f"{head}:HBridge?": lambda c, n, a: on_off(c.board.pin_bridge.get(_pin(side, n), False)),
        head: _set_level(side),
        f"{head}?": lambda c, n, a: on_off(_pin(side, n) in c.board.registers.pins),
    }


def _set_word(name: str, *words: str, configuration: bool = False) -> Handler:
    def handle(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
        if configuration:
            need(c.board, Mode.CONFIGURATION)
        c.board.words[name] = word(a, *words)
        return "1"

    return handle


def set_counter(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    """`RP:COUnter:SAMPlesperstep`, kept in clocks."""
    configurable(c.board)
    c.board.counter_clocks = whole(a) * c.board.decimation
    return "1"


def _set_number(name: str) -> Handler:
    def handle(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
        need(c.board, Mode.CONFIGURATION)
        c.board.numbers[name] = whole(a)
        return "1"

    return handle


def _set_instant_reset(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
    c.board.words["instant_reset"] = word(a, "ON", "OFF")
    c.board.check_emergency()
    return "1"


def _set_counter_trigger(name: str) -> Handler:
    def handle(c: Connection, _: tuple[int, ...], a: list[str]) -> str:
        on = word(a, "ON", "OFF") == "ON"
        c.board.counter_trigger[name] = on
        if on is (name == "reset") and name != "armed":  # a reset disarms, and so does switching it off
            c.board.counter_trigger["armed"] = False
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


SERVER: dict[str, Handler] = (
    {
        "*CLS": lambda c, n, a: c.errors.clear(),
        "*ESE": lambda c, n, a: None,
        "*ESE?": lambda c, n, a: "0",
        "*ESR?": lambda c, n, a: "0",
        "*IDN?": lambda c, n, a: "CUSTOM,REDPITAYA,0,0.1",
        "*OPC": lambda c, n, a: None,
        "*OPC?": lambda c, n, a: "1",
        "*RST": lambda c, n, a: None,
        "*SRE": lambda c, n, a: None,
        "*SRE?": lambda c, n, a: "0",
        "*STB?": lambda c, n, a: "0",
        "*TST?": lambda c, n, a: "0",
        "*WAI": lambda c, n, a: None,
        "SYSTem:ERRor?": _next_error,
        "SYSTem:ERRor:NEXT?": _next_error,
        "SYSTem:ERRor:COUNt?": lambda c, n, a: str(len(c.errors)),
        "SYSTem:VERSion?": lambda c, n, a: "1999.0",
        "RP:VERsion:IMAGe?": lambda c, n, a: str(c.board.options.image_version),
        "RP:VERsion:IMaGe?": lambda c, n, a: str(c.board.options.image_version),
        "RP:VERsion:SERVer?": lambda c, n, a: str(c.board.options.server_version),
        "RP:MODe": set_mode,
        "RP:MODe?": lambda c, n, a: quoted(c.board.mode.value),
        "RP:LOG?": lambda c, n, a: c.send_log(),
        "RP:PERF?": lambda c, n, a: c.send_performance(),
        "RP:STATus?": lambda c, n, a: str(c.board.status()),
        "RP:STATus:OVERwritten?": lambda c, n, a: str(c.board.status() & 1),
        "RP:STATus:CORRupted?": lambda c, n, a: str(c.board.status() >> 1 & 1),
        "RP:STATus:LOSTSteps?": lambda c, n, a: str(c.board.status() >> 2 & 1),
        "RP:WatchDogMode": _set_word("watchdog", "ON", "OFF"),
        "RP:WatchDogMode?": lambda c, n, a: quoted(c.board.words["watchdog"]),
        "RP:InstantReset:MODe": _set_instant_reset,
        "RP:InstantReset:MODe?": lambda c, n, a: quoted(c.board.words["instant_reset"]),
        "RP:InstantReset:STATus?": lambda c, n, a: str(int(c.board.emergency_pressed)),
        "RP:InstantReset:TRIGgered?": lambda c, n, a: str(int(c.board.emergency_latched)),
        "RP:COUnter:SAMPlesperstep": set_counter,
        "RP:COUnter:SAMPlesperstep?": lambda c, n, a: str(c.board.counter_clocks // c.board.decimation),
        "RP:CounterTrigger:ENable": _set_counter_trigger("enabled"),
        "RP:CounterTrigger:ENable?": lambda c, n, a: on_off(c.board.counter_trigger["enabled"]),
        "RP:CounterTrigger:ARM": _set_counter_trigger("armed"),
        "RP:CounterTrigger:ARM?": lambda c, n, a: str(int(c.board.counter_trigger["armed"])),
        "RP:CounterTrigger:RESet": _set_counter_trigger("reset"),
        "RP:CounterTrigger:RESet?": lambda c, n, a: on_off(c.board.counter_trigger["reset"]),
        "RP:CounterTrigger:PREsamples": _set_number("presamples"),
        "RP:CounterTrigger:PREsamples?": lambda c, n, a: str(c.board.numbers["presamples"]),
        "RP:CounterTrigger:COUNTer:LAst?": lambda c, n, a: "0",
        "RP:CounterTrigger:COUNTer:REFerence": _set_number("reference"),
        "RP:CounterTrigger:COUNTer:REFerence?": lambda c, n, a: str(c.board.numbers["reference"]),
        "RP:CounterTrigger:SouRCe:TYPe": _set_word("source_type", "DIO", "ADC", configuration=True),
        "RP:CounterTrigger:SouRCe:TYPe?": lambda c, n, a: quoted(c.board.words["source_type"]),
        "RP:CounterTrigger:SouRCe:CHANnel": set_source,
        "RP:CounterTrigger:SouRCe:CHANnel?": lambda c, n, a: quoted(c.board.words["source"]),
    }
    | _pin_commands("N")
    | _pin_commands("P")
)
